"""Bursts of prey and predators, which tire within seconds."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.kernels import kernel
from subsea.state import Clock, Fishes, Minds

LASTING_S = 3.0  # of full burst, after which a fish is no faster than its sustained speed ...
FRESH = 0.4  # ... and the share of that time for which it is at its fastest
RECOVERS = 0.08  # s of burst recovered in a second without one


@kernel
def burst(fishes: Fishes, minds: Minds, i: int) -> None:
    """Let fish i swim as fast as it can: at its burst speed while fresh, less as it tires."""
    fresh = min(max(1.0 - minds.spent[i] / LASTING_S, 0.0) / (1.0 - FRESH), 1.0)
    fishes.goal_speed[i] = 1.0 + (max(fishes.burst[i], 1.0) - 1.0) * fresh


@kernel
def tire(who: Ints, fishes: Fishes, minds: Minds, clock: Clock) -> None:
    """Count the time of bursts of the fishes `who`, by their effort, and their rest."""
    for i in who:
        effort = (fishes.goal_speed[i] - 1.0) / max(fishes.burst[i] - 1.0, 1e-3)
        change = min(effort, 1.0) if effort > 0.0 else -RECOVERS
        minds.spent[i] = max(minds.spent[i] + np.float32(change * clock.dt), np.float32(0.0))
        minds.startled[i] += np.float32(clock.dt)
