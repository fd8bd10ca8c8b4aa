"""`subsea/Escape-v0`: a prey fish near a hungry predator."""

from typing import Any

import numpy as np

from subsea.base.arrays import Ints
from subsea.base.errors import UserError
from subsea.geometry.rotation import x_axis
from subsea.lab.environments.rewards import Reward, escape_reward
from subsea.lab.environments.steered_fish import SteeredFishEnv
from subsea.state import PREDATOR, PREY

START_CM = (200.0, 400.0)  # distance of the start from the predator ...
ASIDE_RAD = np.radians(15.0)  # ... and its greatest angle from the predator's heading
DEPTH_CM = 20.0  # greatest difference in depth


class EscapeEnv(SteeredFishEnv):
    """Steer a prey fish that begins before the nose of a predator; it ends when it is caught.

    Each episode draws the fish, unless `fish` names it, the predator and the start, 200 to 400 cm
    ahead of the predator.
    """

    wanted = "prey fishes"

    def __init__(
        self, scenario: str = "preying", fish: int | str | None = None,
        observation: str = "senses", reward: Reward = escape_reward,
        render_mode: str | None = None, **options: Any,
    ) -> None:  # fmt: skip
        """Build the sea; `options` are those of `living_sea.SeaOptions`. Raises a UserError.

        `fish`: a number, a species or SPECIES:NUMBER. `observation`: "senses" or "retina".
        """
        super().__init__(scenario, fish, observation, reward, render_mode, **options)
        self._predators = np.flatnonzero(self.sea.world.state.minds.kind == PREDATOR)
        if not len(self._predators):
            raise UserError(f"scenario {scenario}: it has no predator")

    def candidates(self) -> Ints:
        """All prey."""
        return np.flatnonzero(self.sea.world.state.minds.kind == PREY)

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
