"""Whom a fish may mate with (Tu §7.9.3)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.vector import minus, norm, vector
from subsea.perception.grid import Grid, first_ring, insert, last_ring, ring_distance, ring_slots
from subsea.perception.vision import Bodies, Scene, eye_of, sees_fish, sight
from subsea.state import PACIFIST, Minds, Nature

Ints = NDArray[np.integer[Any]]

CELL_CM = 100.0
STRANGE_CM = 1e6  # so much farther away a fish of another species counts


@njit(cache=True, error_model="numpy")
def see_mates(
    who: Ints, bodies: Bodies, minds: Minds, species: Ints, scene: Scene, grid: Grid, nature: Nature
) -> None:
    """Enter possible mates in sight of the fishes `who`, from the pacifists in `grid`.

    They are of the other sex; those of the same species come first, then the nearest.
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
                    if minds.male[i] == minds.male[j]:
                        continue
                    price = norm(minus(vector(grid.place[slot]), eye))
                    if species[i] != species[j]:
                        price += STRANGE_CM
                    if price <= cost[-1] and sees_fish(bodies, i, j, scene, nature):
                        insert(found, cost, j, price)
        minds.mate[i] = found[0]
        minds.mate_distance[i] = cost[0] - STRANGE_CM if cost[0] >= STRANGE_CM else cost[0]
