"""Fishes that intrude into the territory of another one."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.vector import ZERO, dot, minus, vector
from subsea.kernels import kernel
from subsea.perception.crowd import Crowd, Path, find_meetings, place_of, room_for
from subsea.state import CLEANS, NO_COURTSHIP, NOBODY, PREDATOR, Fishes, Minds

FOLLOWS = 1.5  # radii of a territory to which a resident follows an intruder
NEIGHBOURS = 0.5  # share of the radius in which a neighbour is driven off again, for ...
KNOWN_S = 90.0  # ... this long after a chase, as in `behavior/territory.py`
OUTSIZED = 4.0  # a fish this many times as long as the resident is let alone


@kernel
def find_intruders(who: Ints, fishes: Fishes, minds: Minds, crowd: Crowd) -> None:
    """Set `minds.intruder` of those of the fishes `who` that guard a territory.

    The nearest fish of another species counts. One that is followed counts until it is far off.
    Schools, predators, cleaners, courting fishes and much larger ones are let alone. One that was
    chased off lately is a known neighbour, which is tolerated farther out (Fisher 1954).
    """
    if not (minds.territory[who] > 0.0).any():
        return
    slots = room_for(crowd)
    for i in who:
        radius = float(minds.territory[i])
        if radius <= 0.0:
            continue
        home, here = vector(minds.home[i]), vector(fishes.position[i])
        now, best, least = minds.intruder[i], int(NOBODY), np.inf
        row, count = find_meetings(crowd, Path(home, ZERO, FOLLOWS * radius, 0.0), slots)
        for k in range(count):
            slot = slots[row, k]
            j = crowd.member[slot]
            if j == NOBODY or not _counts(fishes, minds, i, j):
                continue
            off = minus(place_of(crowd, slot), home)
            reach = FOLLOWS * radius if j == now else radius
            if minds.chaser[j] == i and 0.0 < minds.chased[j] <= KNOWN_S:
                reach = NEIGHBOURS * radius
            if dot(off, off) > reach * reach:
                continue
            away = minus(place_of(crowd, slot), here)
            far = dot(away, away) * (0.5 if j == now else 1.0)
            if far < least or (far == least and j < best):
                best, least = j, far
        minds.intruder[i] = best


@kernel
def _counts(fishes: Fishes, minds: Minds, i: int, j: int) -> bool:
    """True if fish i would chase fish j off."""
    if fishes.species[i] == fishes.species[j] or minds.kind[j] == PREDATOR or minds.schools[j]:
        return False
    if minds.ways[j] & CLEANS or minds.courtship[j] != NO_COURTSHIP or minds.betrothed[j] != NOBODY:
        return False
    return bool(fishes.length[j] < OUTSIZED * fishes.length[i])
