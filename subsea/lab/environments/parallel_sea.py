"""A PettingZoo environment in which many fishes of a living sea are steered."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from pettingzoo import ParallelEnv

from subsea.base.arrays import Bytes, Ints
from subsea.base.errors import UserError
from subsea.lab.environments.living_sea import (
    ACTIONS,
    NAMES,
    LivingSea,
    Outcome,
    checked_action,
    senses,
)
from subsea.lab.environments.rewards import Reward
from subsea.lab.environments.showing import RENDER_MODES, Shown, check_render_mode
from subsea.library import World
from subsea.scenario.shoals import find_fish

SPREAD_CM = 30.0  # of starts about the places in the scenario
TURN_RAD = np.radians(20.0)  # greatest turn of a start
Agents = Sequence[int | str] | None


class ParallelSea(ParallelEnv):  # type: ignore[misc]
    """Agents are fishes, named by species and number such as "fusilier_0"; others have own minds.

    Agents that die are in the terminations of that step and do not return.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES}  # noqa: RUF012 as in the base

    def __init__(
        self, name: str, sea: LivingSea, who: Ints, reward: Reward, render_mode: str | None
    ) -> None:
        """Steer the fishes `who` of a sea; a UserError if there are none."""
        check_render_mode(render_mode)
        if not len(who):
            raise UserError(f"scenario {sea.options.scenario}: it has no fish for an agent")
        fps = sea.decisions_per_second
        self.metadata = self.metadata | {"name": name, "render_fps": fps, "is_parallelizable": True}
        self.sea, self.render_mode, self._reward = sea, render_mode, reward
        kinds = sea.species
        self._fish = {f"{kinds[i]}_{kinds[:i].count(kinds[i])}": i for i in who.tolist()}
        self.possible_agents = list(self._fish)
        self.agents: list[str] = []
        self.action_spaces = {
            agent: Box(-1.0, 1.0, (len(ACTIONS),), np.float32) for agent in self._fish
        }
        self.observation_spaces = {
            agent: Box(-1.0, 1.0, (len(NAMES),), np.float32) for agent in self._fish
        }
        self._rng = np.random.default_rng()
        self._steps = 0
        self._shown = Shown(render_mode, fps)

    @property
    def world(self) -> World:
        """The sea, to read, draw or record."""
        return self.sea.library_world

    def observation_space(self, agent: str) -> Box:
        """Describe the senses of a fish; the same object for each call."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Box:
        """Describe turn, rise and speed in [-1, 1]; the same object for each call."""
        return self.action_spaces[agent]

    def fish_of(self, agent: str) -> int:
        """Look up the index of an agent's fish in `sea.world`."""
        return self._fish[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begin an episode; the same seed gives the same episode, bit for bit."""
        if seed is not None:
            self._rng = np.random.default_rng(seed)
        self.sea.begin(self._rng)
        alive = self.sea.world.state.fishes.alive
        self.agents = [agent for agent, fish in self._fish.items() if alive[fish]]
        self._steps = 0
        who = self._who()
        self.sea.turn(who, self._rng, SPREAD_CM, TURN_RAD)
        outcome = self.sea.advance(who, np.zeros((len(who), len(ACTIONS))), ticks=1)
        self._shown.update(self._draw)
        return self._observations(who), self._infos(outcome)

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[
        dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool],
        dict[str, dict[str, Any]],
    ]:  # fmt: skip
        """Steer all agents until their next decision.

        A ValueError for an action of another shape or with NaN, of a dead or unknown agent, and if
        one is missing.
        """
        for agent in actions:
            if agent not in self.agents:
                state = "is not alive" if agent in self._fish else "is unknown"
                raise ValueError(f"agent {agent} {state}: expected actions of `agents` only")
        for agent in self.agents:
            if agent not in actions:
                raise ValueError(f"agent {agent} has no action")
        if not self.agents:
            return {}, {}, {}, {}, {}
        chosen = np.array([checked_action(actions[agent], agent) for agent in self.agents])
        who = self._who()
        outcome = self.sea.advance(who, chosen)
        self._steps += 1
        late = self._steps >= self.sea.options.max_steps
        rewards = self._reward(outcome)
        told = (
            self._observations(who),
            {agent: float(rewards[k]) for k, agent in enumerate(self.agents)},
            {agent: not outcome.alive[k] for k, agent in enumerate(self.agents)},
            {agent: bool(late and outcome.alive[k]) for k, agent in enumerate(self.agents)},
            self._infos(outcome),
        )
        self._shown.update(self._draw)
        living = zip(self.agents, outcome.alive, strict=True)
        self.agents = [agent for agent, alive in living if alive and not late]
        return told

    def render(self) -> Bytes | None:
        """Draw the first living agent from behind (height, width, 3), with "rgb_array".

        With "human", `reset` and `step` show it in a window.
        """
        return self._shown.render(self._draw)

    def _draw(self) -> Bytes:
        return self.sea.pictures.behind(self._fish[(self.agents or self.possible_agents)[0]])

    def close(self) -> None:
        """Release the renderer and the window."""
        self._shown.close()
        self.sea.close()

    def _who(self) -> Ints:
        return np.array([self._fish[agent] for agent in self.agents])

    def _observations(self, who: Ints) -> dict[str, Any]:
        return dict(zip(self.agents, senses(self.sea.world, who), strict=True))

    def _infos(self, outcome: Outcome) -> dict[str, dict[str, Any]]:
        return {agent: {"meals": float(outcome.meals[k])} for k, agent in enumerate(self.agents)}


def chosen_agents(sea: LivingSea, agents: Agents) -> Ints:
    """Find fishes by numbers, species (all of it) or SPECIES:NUMBER, in rising order.

    None: all fishes. A UserError for an unknown one.
    """
    if agents is None:
        return np.arange(len(sea.species))
    chosen: set[int] = set()
    for one in [agents] if isinstance(agents, str) else agents:
        first = find_fish(str(one), sea.scenario)
        if str(one) in sea.species:
            chosen.update(k for k, name in enumerate(sea.species) if name == one)
        else:
            chosen.add(first)
    return np.array(sorted(chosen), np.int64)
