"""Predators and prey that are steered, by the convention of PettingZoo."""

from typing import Any

import numpy as np

from subsea.lab.environments.living_sea import LivingSea, sea_options
from subsea.lab.environments.parallel_sea import Agents, ParallelSea, chosen_agents
from subsea.lab.environments.rewards import Reward, hunt_reward
from subsea.state import PREDATOR, PREY


def parallel_env(
    scenario: str = "preying", agents: Agents = None, reward: Reward = hunt_reward,
    render_mode: str | None = None, **options: Any,
) -> ParallelSea:  # fmt: skip
    """Steer all predators and prey of a scenario as agents, or `agents` as in `school`.

    The reward is catches for predators, and survival for others. `options` are those of
    `living_sea.SeaOptions`. Raises a UserError for a faulty option.
    """
    sea = LivingSea(sea_options(scenario, options))
    who = chosen_agents(sea, agents)
    if agents is None:
        who = who[np.isin(sea.world.state.minds.kind[who], (PREDATOR, PREY))]
    return ParallelSea("subsea_predator_prey", sea, who, reward, render_mode)
