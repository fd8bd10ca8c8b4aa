"""Isosurfaces of sampled fields by naive surface nets (Gibson 1998)."""

import numpy as np

from subsea.base.arrays import Array, Ints


def surface_net(field: Array) -> tuple[Array, Ints]:
    """The zero surface of a field (a, b, c): vertices (n, 3) in cells, triangles (m, 3).

    Each cell that the surface crosses has one vertex, the mean of the crossings of its edges; each
    edge of the grid that it crosses has one square. Triangles are counter-clockwise seen from
    where the field is positive. The surface ends at the edge of the grid.
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
        # Four cells share each edge.
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
    """The four cells (n, 3) around edges along an axis, counter-clockwise from its far end."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    around = []
    for step in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
        cell = edges.copy()
        cell[:, one] += step[0]
        cell[:, other] += step[1]
        around.append(cell)
    return around
