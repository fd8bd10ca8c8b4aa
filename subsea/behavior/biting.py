"""Bait on a hook (Tu §10.1): hungry fishes approach it, and the first to bite is caught.

To struggle on the hook is the most urgent behavior.
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase, mouth_of, set_urge
from subsea.behavior.death import pass_leadership, remove
from subsea.geometry.noise import uniform
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
YANK_CM_S = 150.0  # fastest pull of the catch to the hook
OUT_BL = 0.6  # height of its middle above the surface at which a catch is removed
HOLD_TICKS = 14  # how long a struggling catch keeps its direction
DIVE = 0.3, 0.6  # range of its slope downward
GASP = 0.6  # how far the mouth is held open
HEADING_PURPOSE, DIVE_PURPOSE = np.int64(70), np.int64(71)  # keys of the random numbers


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


@kernel
def hooked_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Set the strongest desire of all for the fish on the hook."""
    for i in who:
        out[i] = 2.0 if sea.catch[0] == HOOKED and sea.catch[1] == i else 0.0


@kernel
def struggle(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
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
