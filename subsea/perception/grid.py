"""Sort points into a uniform grid, and search for neighbours in it.

The lateral line feels the nearest companions in all directions (Tu §6.3).
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.vector import Vector, dot, minus, store, times, vector
from subsea.kernels import kernel
from subsea.state import Fishes, Minds
from subsea.state.places import place_near
from subsea.state.school_rules import LATERAL_LINE_BL, SIGHT_BL

CELLS_EACH, CELLS_MORE = 16, 16384  # most cells: per point, and in addition
FEW = 48  # most points for which a pass over all is faster than cells
LEAST_CM = 1.0  # first range of a search
ROUNDING, MARGIN = 1.0 + 1e-9, 1.0 + 1e-6


class Grid(NamedTuple):
    """m points, sorted by their cubic cell; points of a cell keep their order."""

    low: Vector  # cm, the corner where the first cell begins
    cell: float  # cm, side of a cell
    size: tuple[int, int, int]  # cells along x, y, z; those along z follow one another
    start: Ints  # (cells + 1,) int32, where the points of each cell begin; empty for few points
    member: Ints  # (m,) int64, what the point belongs to
    place: Array  # (m, 3) float64, cm


@kernel
def make_grid(points: Array, chosen: Ints, cell: float) -> Grid:
    """Sort the points `chosen`, rising indices of `points` (n, 3), by cells of `cell` cm.

    Cells grow until their number is in proportion to the points.
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
    for k in range(m):
        a = int((points[chosen[k], 0] - corner[0]) / cell)
        b = int((points[chosen[k], 1] - corner[1]) / cell)
        c = int((points[chosen[k], 2] - corner[2]) / cell)
        home[k] = (a * cells[1] + b) * cells[2] + c
    member = np.empty(m, np.int64)
    if m <= FEW:
        start = np.empty(0, np.int32)
        for k in range(m):
            slot = k
            while slot > 0 and home[slot - 1] > home[slot]:
                home[slot - 1], home[slot] = home[slot], home[slot - 1]
                member[slot] = member[slot - 1]
                slot -= 1
            member[slot] = chosen[k]
    else:
        # Shifted by a cell, `start` first counts where the next point of each cell goes.
        start = np.zeros(cells[0] * cells[1] * cells[2] + 2, np.int32)
        for k in range(m):
            start[home[k] + 2] += 1
        for k in range(2, len(start)):
            start[k] += start[k - 1]
        for k in range(m):
            member[start[home[k] + 1]] = chosen[k]
            start[home[k] + 1] += 1
        start = start[:-1]
    place = np.empty((m, 3))
    for slot in range(m):
        store(place[slot], vector(points[member[slot]]))
    return Grid(corner, cell, cells, start, member, place)


@kernel
def make_grid_of_images(points: Array, chosen: Ints, cell: float, period: Array) -> Grid:
    """Sort the points `chosen` as `make_grid` does, in a box together with their images.

    Searches take `place` from the grid, and subtract.
    """
    if period[0] <= 0.0:
        return make_grid(points, chosen, cell)
    images, member = images_of(points, chosen, period)
    grid = make_grid(images, np.arange(len(member)), cell)
    for slot in range(len(member)):
        grid.member[slot] = member[grid.member[slot]]
    return grid


@kernel
def images_of(points: Array, chosen: Ints, period: Array) -> tuple[Array, Ints]:
    """The places (m, 3) of the points `chosen`, in a box with their images; and whose they are.

    In a box each point is there four times: where it is, and beyond the nearer side along x, along
    y and along both. So every image within half a period of a place in the box is there.
    """
    copies = 4 if period[0] > 0.0 else 1
    images = np.empty((copies * len(chosen), 3))
    member = np.empty(copies * len(chosen), np.int64)
    for k in range(len(chosen)):
        x, y, z = times(1.0, vector(points[chosen[k]]))  # in double precision
        for copy in range(copies):
            beyond_x = math.copysign(1.0, x) * period[0] if copy & 1 else 0.0
            beyond_y = math.copysign(1.0, y) * period[1] if copy & 2 else 0.0
            store(images[copies * k + copy], (x - beyond_x, y - beyond_y, z))
            member[copies * k + copy] = chosen[k]
    return images, member


@kernel
def near_slots(grid: Grid, p: Vector, reach: float, slots: Ints) -> int:
    """Write the slots of all points near p to `slots` and return their number.

    They include all points within `reach` cm and some farther ones; `slots` must have room for all
    m. (Numba cannot cache generators.)
    """
    if len(grid.member) <= FEW:
        for slot in range(len(grid.member)):
            slots[slot] = slot
        return len(grid.member)
    low, size = grid.low, grid.size
    first_a, last_a = cells_within(p[0] - low[0], reach, grid.cell, size[0])
    first_b, last_b = cells_within(p[1] - low[1], reach, grid.cell, size[1])
    first_c, last_c = cells_within(p[2] - low[2], reach, grid.cell, size[2])
    count = 0
    if first_c > last_c:
        return 0
    x, y = p[0] - low[0], p[1] - low[1]
    for a in range(first_a, last_a + 1):
        aside = max(a * grid.cell - x, x - (a + 1) * grid.cell, 0.0)
        for b in range(first_b, last_b + 1):
            along = max(b * grid.cell - y, y - (b + 1) * grid.cell, 0.0)
            if aside * aside + along * along > ROUNDING * reach * reach:
                continue
            row = (a * grid.size[1] + b) * grid.size[2]
            for slot in range(grid.start[row + first_c], grid.start[row + last_c + 1]):
                slots[count] = slot
                count += 1
    return count


@kernel
def cells_within(middle: float, reach: float, cell: float, size: int) -> tuple[int, int]:
    """First and last of `size` cells along an axis within `reach`, cm; none if last < first."""
    first, last = np.floor((middle - reach) / cell), np.floor((middle + reach) / cell)
    return int(max(first, 0.0)), int(min(last, size - 1.0))


@kernel
def nearest(
    grid: Grid, p: Vector, reach: float, but: int, found: Ints, gaps: Array, guess: float
) -> None:
    """Write the members nearest to p to `found` (k,) and their distances, cm, to `gaps` (k,).

    All are nearer than `reach`, and the member `but` is left out; missing ones are -1 at infinity.
    Of equal distances the lower index comes first. `guess` is a distance, cm, within which k
    members are expected; the search widens while it has found too few.
    """
    found[:] = -1
    gaps[:] = np.inf
    x, y = p[0] - grid.low[0], p[1] - grid.low[1]
    few = len(grid.member) <= FEW
    inner, outer = -1.0, reach if few else min(max(guess, LEAST_CM), reach)
    while True:
        # The tolerance keeps rounding from separating equals.
        bound = ROUNDING * min(outer, gaps[-1])
        first_a, last_a = cells_within(x, bound, grid.cell, grid.size[0])
        first_b, last_b = cells_within(y, bound, grid.cell, grid.size[1])
        first_c, last_c = cells_within(p[2] - grid.low[2], bound, grid.cell, grid.size[2])
        if few:  # one row of all
            first_a, last_a, first_b, last_b = 0, 0, 0, 0
        elif first_c > last_c:
            last_a = first_a - 1
        for a in range(first_a, last_a + 1):
            aside = max(a * grid.cell - x, x - (a + 1) * grid.cell, 0.0)
            for b in range(first_b, last_b + 1):
                along = max(b * grid.cell - y, y - (b + 1) * grid.cell, 0.0)
                if not few and aside * aside + along * along > bound * bound:
                    continue
                row = (a * grid.size[1] + b) * grid.size[2]
                first = 0 if few else grid.start[row + first_c]
                end = len(grid.member) if few else grid.start[row + last_c + 1]
                for slot in range(first, end):
                    away = minus(vector(grid.place[slot]), p)
                    squared = dot(away, away)
                    if squared > bound * bound or grid.member[slot] == but:
                        continue
                    gap = math.sqrt(squared)
                    if inner < gap <= outer and gap < reach:
                        insert(found, gaps, grid.member[slot], gap)
                        bound = min(bound, ROUNDING * gaps[-1])
        if gaps[-1] <= outer or outer >= reach:
            break
        inner, outer = outer, min(2.0 * outer, reach)


@kernel
def farthest(place: Array, p: Vector, found: Ints) -> float:
    """A guess for `nearest` from what it found the last time: the distance of the farthest, cm.

    There are still as many as near; infinity if there were too few.
    """
    square = 0.0
    for k in found:
        if k < 0:
            return np.inf
        away = minus(vector(place[k]), p)
        square = max(square, dot(away, away))
    return MARGIN * math.sqrt(square)


@kernel
def _farthest_kept(fishes: Fishes, p: Vector, kept: Ints) -> float:
    """A guess like that of `farthest`, from a list that may have lost members."""
    square = 0.0
    for k in kept:
        if k < 0:
            return MISSING * MARGIN * math.sqrt(square) if square > 0.0 else np.inf
        away = minus(place_near(fishes, k, p), p)
        square = max(square, dot(away, away))
    return MARGIN * math.sqrt(square)


@kernel
def insert(found: Ints, cost: Array, member: int, price: float) -> bool:
    """Insert a member into `found`, sorted by cost, then index; False if it costs too much."""
    slot = len(found) - 1
    if price > cost[slot] or (price == cost[slot] and found[slot] >= 0 and member > found[slot]):
        return False
    while slot > 0 and (
        price < cost[slot - 1] or (price == cost[slot - 1] and member < found[slot - 1])
    ):
        cost[slot], found[slot] = cost[slot - 1], found[slot - 1]
        slot -= 1
    cost[slot], found[slot] = price, member
    return True


REACH_CM = 110.0  # range of companions of fishes that do not school
MISSING = 1.6  # factor on the range in which a fish that lost companions looks for more
CELL_CM = 60.0  # large enough that few cells are empty


def grid_of(fishes: Fishes, kind: int) -> Grid:
    """Sort the living fishes of a species into a grid."""
    fellows = np.flatnonzero(fishes.alive & (fishes.species == kind))
    return make_grid_of_images(fishes.position, fellows, CELL_CM, fishes.period)


@kernel
def find_neighbours(who: Ints, fishes: Fishes, minds: Minds, grid: Grid) -> None:
    """Set `minds.neighbour` of the fishes `who`: the nearest within reach in the grid.

    `companions.keep_perceived` then removes what a schooling fish does not perceive. The grid has
    all fishes of their species. Equal distances are ordered by index, so the result does not depend
    on the order of `who`.
    """
    gaps = np.empty(minds.neighbour.shape[1])
    for i in who:
        here = vector(fishes.position[i])
        reach, guess = REACH_CM, farthest(fishes.position, here, minds.neighbour[i])
        if minds.schools[i]:
            rule = minds.rules[minds.school_rule[i]]
            reach = max(rule[SIGHT_BL], rule[LATERAL_LINE_BL]) * float(fishes.length[i])
            guess = _farthest_kept(fishes, here, minds.neighbour[i])
        nearest(grid, here, reach, i, minds.neighbour[i], gaps, guess)
