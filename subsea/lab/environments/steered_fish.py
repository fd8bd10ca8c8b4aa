"""Gymnasium environments in which a fish of a living sea is steered: to food, or from predators."""

from abc import ABC, abstractmethod
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from subsea.base.arrays import Array, Bytes, Ints
from subsea.base.errors import UserError, unknown
from subsea.geometry.rotation import x_axis
from subsea.lab.environments import living_sea
from subsea.lab.environments.rewards import Reward, escape_reward, forage_reward
from subsea.lab.environments.showing import RENDER_MODES, Shown, check_render_mode
from subsea.library import World
from subsea.scenario.shoals import find_fish
from subsea.state import PREDATOR, PREY

OBSERVATIONS = ["senses", "retina"]
SPREAD_CM = 150.0  # of a fish's start about its place in the scenario
START_CM = (200.0, 400.0)  # distance of the start from the predator ...
ASIDE_RAD = np.radians(15.0)  # ... and its greatest angle from the predator's heading
DEPTH_CM = 20.0  # greatest difference in depth


class SteeredFishEnv(gymnasium.Env[Any, Any], ABC):
    """The base of `ForageEnv` and `EscapeEnv`, which choose and place the fish."""

    scenario: str  # unless another one is given, as the reward
    default_reward: Reward
    wanted: str  # fishes that may be steered, for messages

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES}  # noqa: RUF012 as in the base

    def __init__(
        self, scenario: str | None = None, fish: int | str | None = None,
        observation: str = "senses", reward: Reward | None = None,
        render_mode: str | None = None, **options: Any,
    ) -> None:  # fmt: skip
        """Build the sea; `options` are those of `living_sea.SeaOptions`. Raises a UserError.

        `fish`: a number, a species or SPECIES:NUMBER. `observation`: "senses" or "retina".
        """
        if observation not in OBSERVATIONS:
            raise unknown("observation", str(observation), OBSERVATIONS)
        check_render_mode(render_mode)
        self.sea = living_sea.LivingSea(living_sea.sea_options(scenario or self.scenario, options))
        self.metadata = self.metadata | {"render_fps": self.sea.decisions_per_second}
        self._candidates = self.candidates()
        if fish is not None:
            chosen = find_fish(str(fish), self.sea.scenario)
            if chosen not in self._candidates:
                raise UserError(f"fish {fish}: expected one of the {self.wanted}")
            self._candidates = np.array([chosen])
        if not len(self._candidates):
            raise UserError(f"scenario {self.sea.options.scenario}: it has no {self.wanted}")
        self.render_mode, self._observation = render_mode, observation
        fps = self.sea.decisions_per_second
        self._shown = Shown(render_mode, fps)
        self._reward = reward or self.default_reward
        self._who = self._candidates[:1]
        self._steps, self._over = 0, True
        self.action_space = Box(-1.0, 1.0, (len(living_sea.ACTIONS),), np.float32)
        width, height = self.sea.options.retina_size
        self.observation_space = Box(-1.0, 1.0, (len(living_sea.NAMES),), np.float32)
        if observation == "retina":
            self.observation_space = Box(0, 255, (height, 2 * width, 3), np.uint8)

    @abstractmethod
    def candidates(self) -> Ints:
        """Find the fishes that may be steered."""

    @abstractmethod
    def start(self, fish: int) -> None:
        """Place the fish at the start of an episode."""

    @property
    def world(self) -> World:
        """The sea, to read, draw or record."""
        return self.sea.library_world

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
        outcome = self.sea.advance(self._who, np.zeros((1, len(living_sea.ACTIONS))), ticks=1)
        self._steps, self._over = 0, False
        self._shown.update(self._draw)
        return self._observe(), self._info(outcome.meals)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Steer the fish until its next decision; see `sea.options.ticks`.

        A ValueError for an action of another shape or with NaN, and for a dead fish.
        """
        chosen = living_sea.checked_action(action)
        if self._over:
            raise ValueError("the fish is dead or the episode has not begun: call reset() first")
        outcome = self.sea.advance(self._who, chosen[None])
        self._steps += 1
        dead = not outcome.alive[0]
        self._over = dead
        late = self._steps >= self.sea.options.max_steps
        reward = float(self._reward(outcome)[0])
        self._shown.update(self._draw)
        return self._observe(), reward, dead, late and not dead, self._info(outcome.meals)

    def render(self) -> Bytes | None:
        """Draw the fish from behind (height, width, 3), with render_mode "rgb_array".

        With "human", `reset` and `step` show it in a window.
        """
        return self._shown.render(self._draw)

    def _draw(self) -> Bytes:
        return self.sea.pictures.behind(self.fish)

    def close(self) -> None:
        """Release the renderer and the window."""
        self._shown.close()
        self.sea.close()

    def _observe(self) -> Array | Bytes:
        if self._observation == "senses":
            return np.asarray(living_sea.senses(self.sea.world, self._who)[0])
        return self.sea.pictures.retina(self.fish, self.sea.options.retina_size)

    def _info(self, meals: Array) -> dict[str, Any]:
        species = self.sea.species[self.fish]
        return {"fish": self.fish, "species": species, "meals": float(meals[0])}


class ForageEnv(SteeredFishEnv):
    """Steer a fish to its food; it eats what comes before its mouth.

    Each episode draws the fish, unless `fish` names it, and its start within about 150 cm of its
    place in the scenario.
    """

    scenario, wanted = "peaceful", "plankton eaters"
    default_reward = staticmethod(forage_reward)

    def candidates(self) -> Ints:
        """Choose all fishes but predators."""
        return np.flatnonzero(self.sea.world.state.minds.kind != PREDATOR)

    def start(self, fish: int) -> None:
        """Scatter the fish."""
        self.sea.scatter(np.array([fish]), self.np_random, SPREAD_CM)


class EscapeEnv(SteeredFishEnv):
    """Steer a prey fish that begins before the nose of a predator; it ends when it is caught.

    Each episode draws the fish, unless `fish` names it, the predator and the start, 200 to 400 cm
    ahead of the predator.
    """

    scenario, wanted = "preying", "prey fishes"
    default_reward = staticmethod(escape_reward)

    def candidates(self) -> Ints:
        """Choose all prey; a UserError if no predator is there."""
        kind = self.sea.world.state.minds.kind
        prey, self._predators = np.flatnonzero(kind == PREY), np.flatnonzero(kind == PREDATOR)
        if len(prey) and not len(self._predators):
            raise UserError(f"scenario {self.sea.options.scenario}: it has no predator")
        return prey

    def start(self, fish: int) -> None:
        """Place the fish ahead of a predator, with a random heading."""
        rng, fishes = self.np_random, self.sea.world.state.fishes
        predator = rng.choice(self._predators)
        ahead = x_axis(fishes.orientation[predator])
        heading = np.arctan2(ahead[1], ahead[0]) + rng.uniform(-ASIDE_RAD, ASIDE_RAD)
        distance = rng.uniform(*START_CM)
        offset = distance * np.array([np.cos(heading), np.sin(heading), 0.0])
        offset[2] = rng.uniform(-DEPTH_CM, DEPTH_CM)
        place = fishes.position[predator] + offset
        self.sea.place(fish, place, rng.uniform(-np.pi, np.pi))
