"""Who is near: a sorted uniform grid, never all pairs."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.state import Fishes

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

REACH_CM = 110.0  # how far a fish looks for companions; also the side of a cell


@njit(cache=True)
def find_neighbours(fishes: Fishes, reach: float) -> None:
    """Fill `fishes.neighbour` with the nearest fishes of the same species within `reach` cm.

    Fishes are sorted by the cell that they are in; each looks into its own cell and the 26
    around it. Equal distances are told apart by index, so the answer does not depend on order.
    """
    n = len(fishes.species)
    fishes.neighbour[:] = -1
    if n == 0:
        return
    position = fishes.position
    low = np.empty(3, np.float64)
    size = np.empty(3, np.int64)
    for axis in range(3):
        low[axis] = position[:, axis].min()
        size[axis] = int((position[:, axis].max() - low[axis]) / reach) + 1
    cell = np.empty(n, np.int64)
    for i in range(n):
        a = int((position[i, 0] - low[0]) / reach)
        b = int((position[i, 1] - low[1]) / reach)
        c = int((position[i, 2] - low[2]) / reach)
        cell[i] = (a * size[1] + b) * size[2] + c
    order = np.argsort(cell, kind="mergesort")
    ranked = cell[order]
    width = fishes.neighbour.shape[1]
    best = np.empty(width, np.float64)
    for i in range(n):
        best[:] = reach * reach
        found = fishes.neighbour[i]
        c = cell[i] % size[2]
        b = (cell[i] // size[2]) % size[1]
        a = cell[i] // (size[2] * size[1])
        for da in range(max(a - 1, 0), min(a + 2, size[0])):
            for db in range(max(b - 1, 0), min(b + 2, size[1])):
                # The cells c-1, c, c+1 of one row follow one another in the sorted list.
                row = (da * size[1] + db) * size[2]
                start = np.searchsorted(ranked, row + max(c - 1, 0))
                stop = np.searchsorted(ranked, row + min(c + 1, size[2] - 1), side="right")
                for k in range(start, stop):
                    j = order[k]
                    if j == i or fishes.species[j] != fishes.species[i]:
                        continue
                    d = 0.0
                    for axis in range(3):
                        gap = np.float64(position[j, axis]) - np.float64(position[i, axis])
                        d += gap * gap
                    last = width - 1
                    if d > best[last] or (d == best[last] and (found[last] < 0 or j > found[last])):
                        continue
                    slot = last
                    while slot > 0 and (
                        d < best[slot - 1] or (d == best[slot - 1] and j < found[slot - 1])
                    ):
                        best[slot] = best[slot - 1]
                        found[slot] = found[slot - 1]
                        slot -= 1
                    best[slot] = d
                    found[slot] = j
