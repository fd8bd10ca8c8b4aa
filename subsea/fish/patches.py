"""Control points on the patches of the hull's faces (Tu §5.4).

Each of the 24 faces of the hull is a bilinear surface between its four corners, cut into sixteen
patches. A control point keeps the offset that it has at rest from the nearest of the 25 patch
nodes, in axes that move with the face: its normal, and the line along its middle.
"""

from itertools import pairwise

import numpy as np

from subsea.base.arrays import Array, Ints

NODES, NOSE, TAIL_UPPER, TAIL_LOWER = 23, 0, 21, 22
PATCHES = 4  # along and across a face


def _faces() -> Ints:
    """Corners (24, 4) of all faces: top, right, bottom, left of the six sections from the nose on.

    Nose and tail tips count double where a face is a triangle.
    """
    rings = [[NOSE] * 4, *([first + k for k in range(4)] for first in range(1, 21, 4))]
    rings.append([TAIL_UPPER, TAIL_UPPER, TAIL_LOWER, TAIL_LOWER])
    return np.array(
        [
            (front[k], front[(k + 1) % 4], back[(k + 1) % 4], back[k])
            for front, back in pairwise(rings)
            for k in range(4)
        ]
    )


FACES = _faces()


def _patch_nodes() -> tuple[Array, Ints]:
    """Weights (600, 23) of the nodes that give all patch nodes, and the face (600,) of each."""
    share = np.linspace(0.0, 1.0, PATCHES + 1)
    s, t = (grid.ravel() for grid in np.meshgrid(share, share, indexing="ij"))
    bilinear = np.stack([(1 - s) * (1 - t), (1 - s) * t, s * t, s * (1 - t)], axis=1)
    weights = np.zeros((len(FACES), len(s), NODES))
    for face, corners in enumerate(FACES):
        for corner, node in enumerate(corners):
            weights[face, :, node] += bilinear[:, corner]
    return weights.reshape(-1, NODES), np.repeat(np.arange(len(FACES)), len(s))


PATCH_NODES, PATCH_FACE = _patch_nodes()


def face_axes(nodes: Array) -> Array:
    """Axes (…, 24, 3, 3) of all faces as columns: normal to both diagonals, tailward, across."""
    a, b, c, d = (nodes[..., FACES[:, corner], :] for corner in range(4))
    normal = np.cross(d - b, c - a)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    along = (c + d) - (a + b)
    along -= (along * normal).sum(axis=-1, keepdims=True) * normal
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    return np.stack([normal, along, np.cross(normal, along)], axis=-1)


def bind_to_patches(rest_nodes: Array, rest_points: Array) -> tuple[Array, Ints, Array]:
    """Weights (p, 23), face (p,) and offset (p, 3) in its axes, of points (p, 3) at rest."""
    nodes, points = np.asarray(rest_nodes, np.float64), np.asarray(rest_points, np.float64)
    places = PATCH_NODES @ nodes
    stations = nodes[[NOSE, 1, 5, 9, 13, 17, TAIL_UPPER], 0]
    section = np.clip(np.searchsorted(-stations, -points[:, 0]) - 1, 0, len(stations) - 2)
    distance = np.linalg.norm(points[:, None] - places[None], axis=2)
    distance[PATCH_FACE[None] // 4 != section[:, None]] = np.inf
    # Ties go to top or bottom, then to the point's own flank, for left-right symmetry.
    side = np.array([0.0, 1.0, 0.0, -1.0])[PATCH_FACE % 4]
    distance += 1e-9 * np.abs(side) * (2.0 - side * np.sign(points[:, 2:]))
    nearest = distance.argmin(axis=1)
    face = PATCH_FACE[nearest].astype(np.int32)
    axes = face_axes(nodes)[face]
    offset = np.einsum("pji,pj->pi", axes, points - places[nearest])
    return PATCH_NODES[nearest], face, offset
