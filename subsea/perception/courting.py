"""Whom a fish may mate with (Tu §7.9.3)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.vector import minus, norm, vector
from subsea.perception.grid import Grid, first_ring, insert, last_ring, ring_distance, ring_slots
from subsea.perception.vision import Bodies, Scene, eye_of, sees_fish, sight
from subsea.state import LOOPING, PACIFIST, Minds, Nature

Ints = NDArray[np.integer[Any]]

CELL_CM = 100.0
ODD = 2.0  # nobody courts a stranger so many times as long, or as short
STRANGE_CM = 1e6  # so much farther away a fish of another species counts


@njit(cache=True, error_model="numpy")
def see_mates(
    who: Ints, bodies: Bodies, minds: Minds, species: Ints, scene: Scene, grid: Grid, nature: Nature
) -> None:
    """Enter possible mates in sight of the fishes `who`, from the pacifists in `grid`.

    Those of the same species come first, then the nearest.
    """
    longest = 0.0
    for j in grid.member:
        longest = max(longest, float(bodies.length[j]))
    cost = np.empty(minds.mates.shape[1])
    slots = np.empty(len(grid.member), np.int64)
    for i in who:
        found = minds.mates[i]
        found[:] = -1
        cost[:] = np.inf
        if minds.kind[i] == PACIFIST:
            eye = eye_of(bodies, i)
            last = last_ring(grid, eye, sight(longest, nature))
            for ring in range(first_ring(grid, eye), last + 1):
                if ring_distance(grid, eye, ring) > cost[-1]:
                    break
                for k in range(ring_slots(grid, eye, ring, slots)):
                    slot = slots[k]
                    j = grid.member[slot]
                    if not _is_possible(bodies, minds, species, i, j):
                        continue
                    price = norm(minus(vector(grid.place[slot]), eye))
                    if species[i] != species[j]:
                        price += STRANGE_CM
                    if price <= cost[-1] and sees_fish(bodies, i, j, scene, nature):
                        insert(found, cost, j, price)
        minds.mate[i] = found[0]
        minds.mate_distance[i] = cost[0] - STRANGE_CM if cost[0] >= STRANGE_CM else cost[0]


@njit(cache=True, error_model="numpy")
def _is_possible(bodies: Bodies, minds: Minds, species: Ints, i: int, j: int) -> bool:
    """Whether fish i might court fish j: of the other sex, not shunned, not circling with another.

    One of another species must be about as large.
    """
    if minds.male[i] == minds.male[j] or minds.shunned[i] == j:
        return False
    if minds.courtship[j] > LOOPING and minds.partner[j] != i:
        return False
    if species[i] == species[j]:
        return True
    return bool(1.0 / ODD < bodies.length[i] / bodies.length[j] < ODD)
