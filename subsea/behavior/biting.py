"""Bait on a hook: hungry fishes approach it, and the first to bite is caught (Tu §10.1)."""

import numpy as np

from subsea.behavior.chasing import chase, mouth_of
from subsea.behavior.death import pass_leadership, remove
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.state import (
    BAIT,
    EAT,
    HANGING,
    HOOKED,
    NOBODY,
    SINKING,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)

TEMPTING = 20.0  # the bait is preferred unless a speck is this many times nearer
COVER_CM = 10.0  # depth below which the bait is visible
BITE_BL = 0.15  # distance from the mouth at which the bait is bitten
OPEN_BL = 0.4  # distance within which the mouth is open
FOLLOWS = 6.0  # 1/s: rate at which the snout of the catch is drawn to the hook
YANK_CM_S = 150.0  # at most
OUT_BL = 0.6  # height of its middle above the surface at which a catch is removed


@kernel
def is_offered(sea: Sea) -> bool:
    """True if a bait is in the water that no fish has bitten."""
    return sea.catch[0] in (SINKING, HANGING) and sea.hook[2] < -COVER_CM


@kernel
def in_reach(fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature) -> bool:
    """True if fish i, not a predator, smells the bait, and no speck is much nearer."""
    distance = norm(minus(vector(sea.hook), mouth_of(fishes, i)))
    return distance < nature.smell_cm and distance < TEMPTING * minds.food_distance[i]


@kernel
def approach(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> None:
    """Head for the bait, with an open mouth once it is near."""
    minds.target[i] = BAIT
    sink = -sea.tackle[3] if sea.catch[0] == SINKING else 0.0
    distance = chase(fishes, minds, i, vector(sea.hook), (0.0, 0.0, sink))
    fishes.gape[i] = 1.0 if distance < OPEN_BL * fishes.length[i] else 0.0


@kernel
def bite(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Catch the first fish whose mouth reaches the bait, and pull the one that is caught.

    Runs every tick, after all drift is set. A catch gives up leading its school, and is removed
    once it is above the surface.
    """
    state = sea.catch[0]
    if state in (SINKING, HANGING):
        nearest = 1.0
        for i in range(len(minds.intention)):
            if not fishes.alive[i] or minds.intention[i] != EAT or minds.target[i] != BAIT:
                continue
            distance = norm(minus(vector(sea.hook), mouth_of(fishes, i)))
            share = distance / (BITE_BL * fishes.length[i])
            if share < nearest:
                nearest = share
                sea.catch[0], sea.catch[1] = HOOKED, i
        if sea.catch[0] == HOOKED:
            pass_leadership(fishes, minds, sea.catch[1])
    elif state == HOOKED and sea.catch[1] != NOBODY:
        i = sea.catch[1]
        gap = minus(vector(sea.hook), mouth_of(fishes, i))
        rise = sea.tackle[3]
        pull = min(FOLLOWS, YANK_CM_S / max(norm(gap), 1e-6))
        for axis in range(3):
            fishes.drift[i, axis] = np.float32(pull * gap[axis] + (rise if axis == 2 else 0.0))
        if fishes.position[i, 2] > OUT_BL * fishes.length[i]:
            sea.catch[1] = NOBODY
            remove(fishes, minds, i)
