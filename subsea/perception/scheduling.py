"""Choose the fishes that think in a tick: far or hidden ones do so less often."""

import numpy as np

from subsea.core.arrays import Ints
from subsea.core.kernels import kernel
from subsea.geometry.vector import minus, norm, vector
from subsea.state import Clock, Fishes, Minds, Sea

NEAR_CM = 400.0  # distance to the submarine within which a fish thinks every tick
FAR_TICKS = 4  # interval beyond, 0.13 s ...
UNSEEN_TICKS = 8  # ... and where the water hides it


@kernel
def fish_due(fishes: Fishes, minds: Minds, sea: Sea, visibility: float, clock: Clock) -> Ints:
    """Rising indices of the living fishes that think now; adds a tick to `minds.pause` of all.

    Turns are spread evenly over ticks. In the first tick all think.
    """
    n = len(minds.intention)
    who = np.empty(n, np.int64)
    count = 0
    submarine = vector(sea.submarine)
    for i in range(n):
        minds.pause[i] += np.float32(clock.dt)
        if not fishes.alive[i]:
            continue
        distance = norm(minus(vector(fishes.position[i]), submarine))
        every = 1
        if distance > NEAR_CM:
            every = FAR_TICKS if distance < visibility else UNSEEN_TICKS
        if clock.tick == 0 or (clock.tick + i) % every == 0:
            who[count] = i
            count += 1
    return who[:count]
