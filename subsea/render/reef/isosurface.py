"""Triangles about the inside of a sampled field: naive surface nets (Gibson 1998)."""

import numpy as np

from subsea.core.arrays import Array, Ints


def surface_net(field: Array) -> tuple[Array, Ints]:
    """Where a field (a, b, c) is 0: places (n, 3) in cells of the grid, triangles (m, 3).

    One vertex lies in each cell that the surface passes, in the mean of where it crosses the
    cell's edges; one square about each edge of the grid that it crosses. Triangles are
    counter-clockwise seen from where the field is positive. The surface ends at the grid's rim.
    """
    inside = field < 0.0
    total = np.zeros([n - 1 for n in field.shape] + [3])
    count = np.zeros([n - 1 for n in field.shape], np.int64)
    crossings = []
    for axis in range(3):
        low, high = (
            tuple(slice(k, n - 1 + k) if a == axis else slice(n) for a, n in enumerate(field.shape))
            for k in (0, 1)
        )
        at = np.argwhere(inside[low] != inside[high])
        here, there = field[low][tuple(at.T)], field[high][tuple(at.T)]
        place = at.astype(np.float64)
        place[:, axis] += here / (here - there)
        crossings.append((at, here < 0.0))
        # An edge is one of four cells'.
        for cell in _about(at, axis):
            valid = ((cell >= 0) & (cell < count.shape)).all(axis=1)
            np.add.at(total, tuple(cell[valid].T), place[valid])
            np.add.at(count, tuple(cell[valid].T), 1)
    used = count > 0
    number = np.full(count.shape, -1)
    number[used] = np.arange(int(used.sum()))
    squares = []
    for axis, (at, leaving) in enumerate(crossings):
        cells = np.stack(_about(at, axis), axis=1)
        whole = ((cells >= 0) & (cells < count.shape)).all(axis=(1, 2))
        corner = number[tuple(np.moveaxis(cells[whole], 2, 0))]
        squares.append(np.where(leaving[whole, None], corner, corner[:, ::-1]))
    a, b, c, d = np.concatenate(squares).T
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return total[used] / count[used][:, None], triangles


def _about(edges: Ints, axis: int) -> list[Ints]:
    """The cells (n, 3) about edges along an axis, counter-clockwise seen from its far end."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    around = []
    for step in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
        cell = edges.copy()
        cell[:, one] += step[0]
        cell[:, other] += step[1]
        around.append(cell)
    return around
