"""Rocks listed by the square cells of the seabed near them, for passes over many places.

Rocks never move, so a world lists them once.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.vector import Vector
from subsea.kernels import kernel

CELL_CM = 200.0
FEW = 8  # rocks that are faster gone through than looked up


class RockCells(NamedTuple):
    """The rocks near each of columns x rows square cells, which cover all places near a rock."""

    west: float  # cm, of the first column
    south: float  # cm, of the first row
    columns: int
    rows: int
    first: Ints  # (cells + 1,) where the rocks of each cell begin in `near`
    near: Array  # (m, 9) rows of `Sea.rocks`, of each cell in their order; all if they are few.
    # The last two columns are the cosine and sine of the yaw.


@kernel
def rock_cells(rocks: Array, reach: float) -> RockCells:
    """List the `rocks` (k, 7) that are within `reach` cm of each cell, level and by their boxes."""
    if len(rocks) <= FEW:
        few = np.empty((len(rocks), 9))
        for k in range(len(rocks)):
            _list_rock(few[k], rocks[k])
        return RockCells(0.0, 0.0, 0, 0, np.zeros(1, np.int64), few)
    west, south, east, north = math.inf, math.inf, -math.inf, -math.inf
    for k in range(len(rocks)):
        far = max(rocks[k, 3], rocks[k, 4]) + reach
        west, east = min(west, rocks[k, 0] - far), max(east, rocks[k, 0] + far)
        south, north = min(south, rocks[k, 1] - far), max(north, rocks[k, 1] + far)
    columns = int((east - west) / CELL_CM) + 1
    rows = int((north - south) / CELL_CM) + 1
    first = np.zeros(columns * rows + 1, np.int64)
    box = np.empty((len(rocks), 4), np.int64)
    for k in range(len(rocks)):
        far = max(rocks[k, 3], rocks[k, 4]) + reach
        box[k, 0] = int((rocks[k, 0] - far - west) / CELL_CM)
        box[k, 1] = int((rocks[k, 0] + far - west) / CELL_CM)
        box[k, 2] = int((rocks[k, 1] - far - south) / CELL_CM)
        box[k, 3] = int((rocks[k, 1] + far - south) / CELL_CM)
        for row in range(box[k, 2], box[k, 3] + 1):
            for column in range(box[k, 0], box[k, 1] + 1):
                first[row * columns + column + 1] += 1
    for cell in range(columns * rows):
        first[cell + 1] += first[cell]
    near, filled = np.empty((first[-1], 9)), first[:-1].copy()
    for k in range(len(rocks)):
        for row in range(box[k, 2], box[k, 3] + 1):
            for column in range(box[k, 0], box[k, 1] + 1):
                slot = filled[row * columns + column]
                _list_rock(near[slot], rocks[k])
                filled[row * columns + column] += 1
    return RockCells(west, south, columns, rows, first, near)


@kernel
def _list_rock(row: Array, rock: Array) -> None:
    """Write a rock (7,) and the cosine and sine of its yaw to `row` (9,)."""
    for item in range(7):
        row[item] = rock[item]
    row[7], row[8] = math.cos(rock[6]), math.sin(rock[6])


@kernel
def rocks_near(cells: RockCells, p: Vector) -> Array:
    """Rows (j, 9) of the rocks listed at p: all within the reach of the cells, and some farther."""
    if cells.columns == 0:
        return cells.near
    x, y = (p[0] - cells.west) / CELL_CM, (p[1] - cells.south) / CELL_CM
    if x < 0.0 or y < 0.0 or x >= cells.columns or y >= cells.rows:
        return cells.near[:0]
    cell = int(y) * cells.columns + int(x)
    return cells.near[cells.first[cell] : cells.first[cell + 1]]
