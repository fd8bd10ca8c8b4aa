"""A mesh in the scaffold of the nodes, by tetrahedra and barycentric coordinates (KS III.A).

The scaffold is a pyramid at the nose, four sections of eight corners and a wedge at the tail. Each
section is divided into five tetrahedra, alternately in two ways, so that neighbours share the
diagonals of their ring. A point has the coordinates at rest in the tetrahedron that contains it,
or outside the scaffold in the nearest one.
"""

from itertools import pairwise

import numpy as np

from subsea.base.arrays import Array, Ints

NODES, NOSE, TAIL_UPPER, TAIL_LOWER = 23, 0, 21, 22


def _tetrahedra() -> Ints:
    """Corners (25, 4): 2 at the nose, 5 in each of four sections, 3 at the tail."""
    rings = [[first + k for k in range(4)] for first in range(1, 21, 4)]
    a, b, c, d = rings[0]
    tetrahedra = [(NOSE, a, b, c), (NOSE, a, c, d)]
    for number, (front, back) in enumerate(pairwise(rings)):
        # Corners k and k + 2 of the front ring stay together, the other two of the back ring.
        k = number % 2
        corners = [(k + place) % 4 for place in range(4)]
        f, g = [front[place] for place in corners], [back[place] for place in corners]
        tetrahedra += [
            (f[0], f[2], g[1], g[3]),
            (f[1], f[0], f[2], g[1]),
            (f[3], f[0], f[2], g[3]),
            (g[0], g[1], g[3], f[0]),
            (g[2], g[1], g[3], f[2]),
        ]
    a, b, c, d = rings[-1]
    tetrahedra += [(a, b, c, TAIL_UPPER), (a, c, d, TAIL_UPPER), (c, d, TAIL_UPPER, TAIL_LOWER)]
    return np.array(tetrahedra)


TETRAHEDRA = _tetrahedra()


def tetrahedral_weights(rest_nodes: Array, rest_points: Array) -> Array:
    """Weights (p, 23) of the nodes for points (p, 3), both at rest and in the same axes.

    At most four weights are nonzero; inside the scaffold none is negative.
    """
    nodes, points = np.asarray(rest_nodes, np.float64), np.asarray(rest_points, np.float64)
    corners = nodes[TETRAHEDRA]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    away = points[:, None] - corners[None, :, 0]
    last = np.einsum("kij,pkj->pki", np.linalg.inv(edges), away)
    shares = np.concatenate([1.0 - last.sum(axis=2, keepdims=True), last], axis=2)
    best = shares.min(axis=2).argmax(axis=1)
    rows = np.arange(len(points))
    weights = np.zeros((len(points), NODES))
    weights[rows[:, None], TETRAHEDRA[best]] = shares[rows, best]
    return weights
