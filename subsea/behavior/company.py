"""Keep off individuals that a fish dislikes, and stay near those that it likes (Tu ch. 11)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import follow, set_urge
from subsea.behavior.threat_memory import place_of
from subsea.behavior.wandering import CRUISE, is_at_home, wander
from subsea.geometry.vector import minus, norm, plus, store, times, unit, vector
from subsea.kernels import kernel
from subsea.state import NOBODY, PREDATOR, PREY, SUBMARINE, Clock, Fishes, Minds, Nature, Sea
from subsea.state.places import place_near

LEAST = 0.15  # strength below which a feeling has no effect
OFF_CM, OFF_BL = 80.0, 4.0  # distance kept for a dislike of 1: this and lengths of the other
HULL_OFF_CM = 400.0  # the same of the submarine
AWAY_CM, AWAY_S = 150.0, 4.0  # way on which a fish goes on when it is far enough, and how long
LEVEL, ONWARD = 0.3, 0.3  # share of the height, and weight of the present course
SHUNS = 0.05, 0.5  # desire to keep off, and how it grows with the dislike
STAYS = 0.015  # desire to stay near: stronger than to wander, weaker than to school
BESIDE_BL = 3.0  # distance at which it is near, in mean lengths
CALL_CM = 350.0  # distance from which it comes for a liking of 1


@kernel
def shun_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Desire to keep off a disliked one that is near, stronger than schooling."""
    base, growth = SHUNS
    for i in who:
        out[i] = 0.0
        k = disliked(fishes, minds, i, sea)
        if k >= 0:
            out[i] = base - growth * float(minds.liking[i, k])


@kernel
def shun(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Swim away from the nearest disliked one, on the level for the most part."""
    for i in who:
        k = disliked(fishes, minds, i, sea)
        if k < 0:
            wander(fishes, minds, i, sea, clock)
            continue
        here = vector(fishes.position[i])
        away = minus(here, place_of(fishes, sea, minds.liked[i, k], here))
        level = unit((away[0], away[1], LEVEL * away[2]))
        if not minds.leads[i]:
            store(minds.waypoint[i], plus(here, times(AWAY_CM, level)))
            minds.patience[i] = AWAY_S
        set_urge(minds, i, plus(level, times(ONWARD, vector(fishes.goal_direction[i]))))
        fishes.goal_speed[i] = CRUISE[1]


@kernel
def stay_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Slightly more than wandering, for a fish that is not near a companion that it likes."""
    for i in who:
        out[i] = STAYS if missed(fishes, minds, i) != NOBODY else 0.0


@kernel
def stay(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Follow the companion that the fish misses, and slow down beside it."""
    for i in who:
        j = missed(fishes, minds, i)
        if j == NOBODY:
            wander(fishes, minds, i, sea, clock)
        else:
            follow(fishes, minds, i, j)
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(CRUISE[1]))


@kernel
def disliked(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> int:
    """Return the slot of the nearest one that fish i dislikes and is too near, or -1.

    Prey leaves its predators and the submarine to fear.
    """
    least, found, here = np.inf, -1, vector(fishes.position[i])
    for k in range(minds.liked.shape[1]):
        j, dislike = minds.liked[i, k], -float(minds.liking[i, k])
        if j == NOBODY or dislike < LEAST:
            continue
        if minds.kind[i] == PREY and (j == SUBMARINE or minds.kind[j] == PREDATOR):
            continue
        reach = HULL_OFF_CM if j == SUBMARINE else OFF_CM + OFF_BL * float(fishes.length[j])
        gap = norm(minus(place_of(fishes, sea, j, here), here))
        if gap < least and gap < dislike * reach:
            least, found = gap, k
    return found


@kernel
def missed(fishes: Fishes, minds: Minds, i: int) -> int:
    """Return the fish that fish i likes most, if it is in call but not beside it, or NOBODY."""
    most, found, here = LEAST, NOBODY, vector(fishes.position[i])
    for k in range(minds.liked.shape[1]):
        j, liking = minds.liked[i, k], float(minds.liking[i, k])
        if j < 0 or liking < most or not fishes.alive[j]:
            continue
        there = place_near(fishes, j, here)
        gap = norm(minus(there, here))
        beside = BESIDE_BL * 0.5 * (fishes.length[i] + fishes.length[j])
        if beside < gap < liking * CALL_CM and is_at_home(minds, i, there):
            most, found = liking, j
    return found
