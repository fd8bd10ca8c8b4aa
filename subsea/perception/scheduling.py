"""Choose the fishes that think in a tick: far or hidden ones do so less often."""

import numpy as np

from subsea.base.arrays import Bools, Ints
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.state import Clock, Fishes, Minds, Sea

NEAR_CM = 400.0  # distance to the submarine within which a fish thinks every tick
FAR_TICKS = 4  # interval beyond, 0.13 s ...
UNSEEN_TICKS = 8  # ... and where the water hides it
LEAST_DUE = 8192  # fishes for which another thread pays


def fish_due(fishes: Fishes, minds: Minds, sea: Sea, visibility: float, clock: Clock) -> Ints:
    """Rising indices of the living fishes that think now; adds a tick to `minds.pause` of all."""
    due = np.empty(len(minds.intention), np.bool_)
    everyone = np.arange(len(due))
    share(mark_due, everyone, LEAST_DUE, fishes, minds, sea, visibility, clock, due)
    return np.flatnonzero(due)


@kernel
def mark_due(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, visibility: float, clock: Clock, due: Bools
) -> None:
    """Set `due` of the fishes `who`, and add a tick to their `minds.pause`.

    Turns are spread evenly over ticks. In the first tick all think.
    """
    submarine = vector(sea.submarine)
    for i in who:
        minds.pause[i] += np.float32(clock.dt)
        due[i] = False
        if not fishes.alive[i]:
            continue
        distance = norm(minus(vector(fishes.position[i]), submarine))
        every = 1
        if distance > NEAR_CM:
            every = FAR_TICKS if distance < visibility else UNSEEN_TICKS
        due[i] = clock.tick == 0 or (clock.tick + i) % every == 0
