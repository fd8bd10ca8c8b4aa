"""A sorted uniform grid over points: who is near, without asking everybody."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.vector import Vector

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

CELLS_EACH, CELLS_MORE = 64, 4096  # at most so many cells for each point, and for them all


class Grid(NamedTuple):
    """m points, sorted by the cubic cell that they are in; equal cells keep their order."""

    low: Vector  # cm, the corner where the first cell begins
    cell: float  # cm, side of a cell
    size: tuple[int, int, int]  # cells along x, y, z; those along z follow one another
    start: Ints  # (cells + 1,) int32, where the points of each cell begin
    member: Ints  # (m,) int64, what the point belongs to
    place: Array  # (m, 3) float64, cm


@njit(cache=True, error_model="numpy")
def make_grid(points: Array, chosen: Ints, cell: float) -> Grid:
    """Sort the points `chosen`, rising indices of `points` (n, 3), by cells of `cell` cm.

    Cells are larger where so many would be needed that most of the work were about empty ones.
    """
    m = len(chosen)
    low, high = np.zeros(3), np.zeros(3)
    for k in range(m):
        for axis in range(3):
            x = float(points[chosen[k], axis])
            low[axis] = x if k == 0 else min(low[axis], x)
            high[axis] = x if k == 0 else max(high[axis], x)
    size = np.ones(3, np.int64)
    while True:
        for axis in range(3):
            size[axis] = int((high[axis] - low[axis]) / cell) + 1
        if float(size[0]) * size[1] * size[2] <= CELLS_EACH * m + CELLS_MORE:
            break
        cell *= 1.25
    corner = (low[0], low[1], low[2])
    cells = (size[0], size[1], size[2])
    home = np.empty(m, np.int64)
    start = np.zeros(cells[0] * cells[1] * cells[2] + 1, np.int32)
    for k in range(m):
        a = int((points[chosen[k], 0] - corner[0]) / cell)
        b = int((points[chosen[k], 1] - corner[1]) / cell)
        c = int((points[chosen[k], 2] - corner[2]) / cell)
        home[k] = (a * cells[1] + b) * cells[2] + c
        start[home[k] + 1] += 1
    for k in range(len(start) - 1):
        start[k + 1] += start[k]
    member, place = np.empty(m, np.int64), np.empty((m, 3))
    filled = start[:-1].copy()
    for k in range(m):
        slot = filled[home[k]]
        filled[home[k]] += 1
        member[slot] = chosen[k]
        for axis in range(3):
            place[slot, axis] = points[chosen[k], axis]
    return Grid(corner, cell, cells, start, member, place)


@njit(cache=True, error_model="numpy")
def cell_of(grid: Grid, p: Vector) -> tuple[int, int, int]:
    """The cell that p lies in, which may be outside of the grid."""
    return (
        int(np.floor((p[0] - grid.low[0]) / grid.cell)),
        int(np.floor((p[1] - grid.low[1]) / grid.cell)),
        int(np.floor((p[2] - grid.low[2]) / grid.cell)),
    )


@njit(cache=True, error_model="numpy")
def first_ring(grid: Grid, p: Vector) -> int:
    """The number of the first ring of cells around p that has a part in the grid."""
    ring = 0
    home = cell_of(grid, p)
    for axis in range(3):
        ring = max(ring, -home[axis], home[axis] - grid.size[axis] + 1)
    return ring


@njit(cache=True, error_model="numpy")
def last_ring(grid: Grid, p: Vector, reach: float) -> int:
    """The number of the last ring of cells around p that has a part in the grid and in reach."""
    ring = 0
    home = cell_of(grid, p)
    for axis in range(3):
        ring = max(ring, home[axis], grid.size[axis] - 1 - home[axis])
    return min(ring, int(reach / grid.cell) + 1)


@njit(cache=True, error_model="numpy")
def ring_distance(grid: Grid, p: Vector, ring: int) -> float:
    """No point of the ring of cells number `ring` around that of p is nearer to p than this."""
    if ring == 0:
        return 0.0
    least = np.inf
    home = cell_of(grid, p)
    for axis in range(3):
        inside = p[axis] - grid.low[axis] - home[axis] * grid.cell
        least = min(least, inside, grid.cell - inside)
    return (ring - 1) * grid.cell + max(least, 0.0)


@njit(cache=True, error_model="numpy")
def ring_slots(grid: Grid, p: Vector, ring: int, slots: Ints) -> int:
    """Enter slots of `member` and `place` whose cell is `ring` cells away from that of p.

    Returns how many there are; `slots` must have room for all m. A generator would read better,
    but compiled ones cannot be kept in numba's cache.
    """
    home_a, home_b, home_c = cell_of(grid, p)
    count = 0
    for a in range(max(home_a - ring, 0), min(home_a + ring + 1, grid.size[0])):
        for b in range(max(home_b - ring, 0), min(home_b + ring + 1, grid.size[1])):
            row = (a * grid.size[1] + b) * grid.size[2]
            rim = abs(a - home_a) == ring or abs(b - home_b) == ring
            # All cells of a row on the rim, else its first and its last.
            step = 1 if rim else max(2 * ring, 1)
            for c in range(home_c - ring, home_c + ring + 1, step):
                if 0 <= c < grid.size[2]:
                    for slot in range(grid.start[row + c], grid.start[row + c + 1]):
                        slots[count] = slot
                        count += 1
    return count


@njit(cache=True, error_model="numpy")
def nearest(
    grid: Grid, p: Vector, reach: float, but: int, found: Ints, gaps: Array, slots: Ints
) -> None:
    """Enter the members nearest to p into `found` (k,) and their distances, cm, into `gaps` (k,).

    They are nearer than `reach` and none is the member `but`; -1 and infinity where there are no
    more. Of those at equal distances the lower index comes first. `slots` (m,) is room to work.
    """
    found[:] = -1
    gaps[:] = np.inf
    last = len(found) - 1
    worst = reach * reach
    for ring in range(first_ring(grid, p), last_ring(grid, p, reach) + 1):
        beyond = ring_distance(grid, p, ring)
        if beyond * beyond > worst:
            break
        for k in range(ring_slots(grid, p, ring, slots)):
            slot = slots[k]
            x = grid.place[slot, 0] - p[0]
            y = grid.place[slot, 1] - p[1]
            z = grid.place[slot, 2] - p[2]
            squared = x * x + y * y + z * z
            if squared > worst or grid.member[slot] == but:
                continue
            if squared < reach * reach and insert(found, gaps, grid.member[slot], squared):
                worst = min(worst, gaps[last])
    for k in range(last + 1):
        gaps[k] = np.sqrt(gaps[k])


@njit(cache=True, error_model="numpy")
def insert(found: Ints, cost: Array, member: int, price: float) -> bool:
    """Put a member among the cheapest `found`, sorted by cost, then index; False if too dear."""
    slot = len(found) - 1
    if price > cost[slot] or (price == cost[slot] and found[slot] >= 0 and member > found[slot]):
        return False
    while slot > 0 and (
        price < cost[slot - 1] or (price == cost[slot - 1] and member < found[slot - 1])
    ):
        cost[slot] = cost[slot - 1]
        found[slot] = found[slot - 1]
        slot -= 1
    cost[slot], found[slot] = price, member
    return True
