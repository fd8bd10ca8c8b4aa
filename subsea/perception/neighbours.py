"""Who is near: a sorted uniform grid, never all pairs."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.state import Fishes, Minds

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

REACH_CM = 110.0  # how far a fish looks for companions; also the side of a cell


@njit(cache=True, error_model="numpy")
def find_neighbours(who: Ints, fishes: Fishes, minds: Minds, reach: float) -> None:
    """Enter into `minds.neighbour` of the fishes `who` the nearest living ones of the same species.

    They are within `reach` cm. Fishes are sorted by the cubic cell that they are in; each looks
    into its own cell and the 26 around it. Equal distances are told apart by index, so the answer
    does not depend on order.
    """
    n = len(fishes.species)
    if n == 0:
        return
    low, size = np.empty(3, np.float64), np.empty(3, np.int64)
    for axis in range(3):
        low[axis] = fishes.position[:, axis].min()
        size[axis] = int((fishes.position[:, axis].max() - low[axis]) / reach) + 1
    cell = np.empty(n, np.int64)
    for i in range(n):
        a = int((fishes.position[i, 0] - low[0]) / reach)
        b = int((fishes.position[i, 1] - low[1]) / reach)
        c = int((fishes.position[i, 2] - low[2]) / reach)
        cell[i] = (a * size[1] + b) * size[2] + c
    order = np.argsort(cell, kind="mergesort")
    ranked, place, species = cell[order], np.empty((n, 3), np.float64), fishes.species[order]
    alive = fishes.alive[order]
    for k in range(n):
        for axis in range(3):
            place[k, axis] = fishes.position[order[k], axis]
    squared = np.empty(minds.neighbour.shape[1], np.float64)
    last = len(squared) - 1
    for i in who:
        x, y, z = (
            np.float64(fishes.position[i, 0]),
            np.float64(fishes.position[i, 1]),
            np.float64(fishes.position[i, 2]),
        )
        kind, found = fishes.species[i], minds.neighbour[i]
        found[:] = -1
        squared[:] = reach * reach
        worst = reach * reach
        c = cell[i] % size[2]
        b = (cell[i] // size[2]) % size[1]
        a = cell[i] // (size[2] * size[1])
        for da in range(max(a - 1, 0), min(a + 2, size[0])):
            for db in range(max(b - 1, 0), min(b + 2, size[1])):
                # The cells c-1, c, c+1 of one row follow one another in the sorted list.
                row = (da * size[1] + db) * size[2]
                start = np.searchsorted(ranked, row + max(c - 1, 0))
                final = row + min(c + 1, size[2] - 1)
                for k in range(start, n):
                    if ranked[k] > final:
                        break
                    gx, gy, gz = place[k, 0] - x, place[k, 1] - y, place[k, 2] - z
                    d = gx * gx + gy * gy + gz * gz
                    if d > worst or species[k] != kind or order[k] == i or not alive[k]:
                        continue
                    j = order[k]
                    if d == worst and (found[last] < 0 or j > found[last]):
                        continue
                    slot = last
                    while slot > 0 and (
                        d < squared[slot - 1] or (d == squared[slot - 1] and j < found[slot - 1])
                    ):
                        squared[slot] = squared[slot - 1]
                        found[slot] = found[slot - 1]
                        slot -= 1
                    squared[slot], found[slot] = d, j
                    worst = squared[last]
