"""`subsea/Forage-v0`: a fish of a living sea that looks for plankton."""

from typing import Any

import numpy as np

from subsea.base.arrays import Ints
from subsea.lab.environments.rewards import Reward, forage_reward
from subsea.lab.environments.steered_fish import SteeredFishEnv
from subsea.state import PREDATOR

SPREAD_CM = 150.0  # of a fish's start about its place in the scenario


class ForageEnv(SteeredFishEnv):
    """Steer a fish to its food; it eats what comes before its mouth.

    Each episode draws the fish, unless `fish` names it, and its start within about 150 cm of its
    place in the scenario.
    """

    wanted = "plankton eaters"

    def __init__(
        self, scenario: str = "peaceful", fish: int | str | None = None,
        observation: str = "senses", reward: Reward = forage_reward,
        render_mode: str | None = None, **options: Any,
    ) -> None:  # fmt: skip
        """Build the sea; `options` are those of `living_sea.SeaOptions`. Raises a UserError.

        `fish`: a number, a species or SPECIES:NUMBER. `observation`: "senses" or "retina".
        """
        super().__init__(scenario, fish, observation, reward, render_mode, **options)

    def candidates(self) -> Ints:
        """All fishes but predators."""
        return np.flatnonzero(self.sea.world.state.minds.kind != PREDATOR)

    def start(self, fish: int) -> None:
        """Scatter the fish."""
        self.sea.scatter(np.array([fish]), self.np_random, SPREAD_CM)
