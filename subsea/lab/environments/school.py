"""A school of steered fishes, by the convention of PettingZoo."""

from typing import Any

from subsea.lab.environments.living_sea import LivingSea, sea_options
from subsea.lab.environments.parallel_sea import Agents, ParallelSea, chosen_agents
from subsea.lab.environments.rewards import Reward, school_reward


def parallel_env(
    scenario: str = "schooling", agents: Agents = None, reward: Reward = school_reward,
    render_mode: str | None = None, **options: Any,
) -> ParallelSea:  # fmt: skip
    """Steer all fishes of a scenario as agents, or `agents`: numbers, species or SPECIES:NUMBER.

    The reward is polarisation and cohesion without collisions. `options` are those of
    `living_sea.SeaOptions`. Raises a UserError for a faulty option.
    """
    sea = LivingSea(sea_options(scenario, options))
    return ParallelSea("subsea_school", sea, chosen_agents(sea, agents), reward, render_mode)
