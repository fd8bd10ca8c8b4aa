"""Struggling on the hook, the most urgent behavior (Tu §10.1)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.geometry.noise import uniform
from subsea.kernels import kernel
from subsea.state import HOOKED, Clock, Fishes, Minds, Nature, Sea

HOLD_TICKS = 14  # how long a direction is held
DIVE = 0.3, 0.6  # slope downward
GASP = 0.6  # how far the mouth is held open
HEADING_PURPOSE, DIVE_PURPOSE = np.int64(70), np.int64(71)  # keys of the random numbers


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """The strongest desire of all, for the fish on the hook."""
    for i in who:
        out[i] = 2.0 if sea.catch[0] == HOOKED and sea.catch[1] == i else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Swim downward at full speed, in a new direction every half second."""
    for i in who:
        epoch = np.int64(clock.tick // HOLD_TICKS)
        fish = np.int64(i)
        heading = 2.0 * np.pi * uniform(clock.seed, fish, epoch, HEADING_PURPOSE)
        low, high = DIVE
        dive = low + (high - low) * uniform(clock.seed, fish, epoch, DIVE_PURPOSE)
        set_urge(minds, i, (np.cos(heading), np.sin(heading), -dive))
        fishes.goal_speed[i] = 1.0
        fishes.gape[i] = GASP
