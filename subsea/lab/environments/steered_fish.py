"""A Gymnasium environment in which one fish of a living sea is steered."""

from abc import ABC, abstractmethod
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from subsea.base.arrays import Array, Bytes, Ints
from subsea.base.errors import UserError, unknown
from subsea.lab.environments.living_sea import (
    ACTIONS,
    NAMES,
    FishPictures,
    LivingSea,
    checked_action,
    sea_options,
    senses,
)
from subsea.lab.environments.rewards import Reward
from subsea.scenario.shoals import find_fish
from subsea.world.world import TICK_S

OBSERVATIONS = ["senses", "retina"]
RENDER_MODES = ["rgb_array"]


class SteeredFishEnv(gymnasium.Env[Any, Any], ABC):
    """The base of `ForageEnv` and `EscapeEnv`, which choose and place the fish."""

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES}  # noqa: RUF012 as in the base

    def __init__(
        self, scenario: str, fish: int | str | None, observation: str, reward: Reward,
        render_mode: str | None, **options: Any,
    ) -> None:  # fmt: skip
        """Build the sea; a UserError for a faulty option."""
        if observation not in OBSERVATIONS:
            raise unknown("observation", str(observation), OBSERVATIONS)
        if render_mode not in (None, *RENDER_MODES):
            raise unknown("render_mode", str(render_mode), RENDER_MODES)
        self.sea = LivingSea(sea_options(scenario, options))
        self.metadata = self.metadata | {
            "render_fps": round(1.0 / (self.sea.options.ticks * TICK_S))
        }
        self._candidates = self.candidates()
        if fish is not None:
            chosen = find_fish(str(fish), self.sea.scenario)
            if chosen not in self._candidates:
                raise UserError(f"fish {fish}: expected one of the {self.wanted}")
            self._candidates = np.array([chosen])
        if not len(self._candidates):
            raise UserError(f"scenario {self.sea.options.scenario}: it has no {self.wanted}")
        self.render_mode, self._observation, self._reward = render_mode, observation, reward
        self._pictures: FishPictures | None = None
        self._who = self._candidates[:1]
        self._steps, self._over = 0, True
        self.action_space = Box(-1.0, 1.0, (len(ACTIONS),), np.float32)
        width, height = self.sea.options.retina_size
        self.observation_space = Box(-1.0, 1.0, (len(NAMES),), np.float32)
        if observation == "retina":
            self.observation_space = Box(0, 255, (height, 2 * width, 3), np.uint8)

    wanted = "fishes"  # that may be steered, for messages

    @abstractmethod
    def candidates(self) -> Ints:
        """The fishes that may be steered."""

    @abstractmethod
    def start(self, fish: int) -> None:
        """Place the fish at the start of an episode."""

    @property
    def fish(self) -> int:
        """Index of the steered fish in `sea.world`."""
        return int(self._who[0])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the same seed gives the same episode, bit for bit."""
        super().reset(seed=seed)
        self.sea.begin(self.np_random)
        self._who = self.np_random.choice(self._candidates, 1)
        self.start(self.fish)
        outcome = self.sea.advance(self._who, np.zeros((1, len(ACTIONS))), ticks=1)
        self._steps, self._over = 0, False
        return self._observe(), self._info(outcome.meals)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Steer the fish until its next decision; see `sea.options.ticks`.

        A ValueError for an action of another shape or with NaN, and for a dead fish.
        """
        chosen = checked_action(action)
        if self._over:
            raise ValueError("the fish is dead or the episode has not begun: call reset() first")
        outcome = self.sea.advance(self._who, chosen[None])
        self._steps += 1
        dead = not outcome.alive[0]
        self._over = dead
        late = self._steps >= self.sea.options.max_steps
        reward = float(self._reward(outcome)[0])
        return self._observe(), reward, dead, late and not dead, self._info(outcome.meals)

    def render(self) -> Bytes | None:
        """The fish from behind (height, width, 3), with render_mode "rgb_array"."""
        return self._drawer().behind(self.fish) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Release the renderer."""
        self._pictures = None

    def _observe(self) -> Array | Bytes:
        if self._observation == "senses":
            return np.asarray(senses(self.sea.world, self._who)[0])
        return self._drawer().retina(self.fish, self.sea.options.retina_size)

    def _drawer(self) -> FishPictures:
        if self._pictures is None:
            self._pictures = FishPictures(self.sea.world, self.sea.options.picture_size)
        return self._pictures

    def _info(self, meals: Array) -> dict[str, Any]:
        species = self.sea.species[self.fish]
        return {"fish": self.fish, "species": species, "meals": float(meals[0])}
