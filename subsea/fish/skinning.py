"""Coupling of the drawn surface to the nodes by one constant matrix per species.

Three methods. Cross-sections are interpolated along the body by a C1 cubic: centre line and axes
are linear in the nodes, hence so are all control points. The bilinear patches of Tu §5.4, whose
axes jump from face to face, so that a bent surface creases: each of the 24 faces of the hull is cut
into sixteen, and a control point keeps the offset that it has at rest from the nearest of the 25
patch nodes, in axes that move with the face. The tetrahedra of KS III.A (`geometry/tetrahedra.py`).
"""

from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.tetrahedra import tetrahedral_weights

RINGS = tuple(range(1, 21, 4))  # the first node of each ring: upper left, clockwise from behind
TAIL_UPPER, TAIL_LOWER = 21, 22


def skin_weights(rest_nodes: Array, rest_points: Array) -> Array:
    """The matrix W (p, 23) with ``points = W @ nodes`` in any frame, exact at rest.

    `rest_nodes` (23, 3), with rings in planes of constant x, and `rest_points` (p, 3) are in the
    same body axes. Rows of W sum to one.
    """
    nodes = np.asarray(rest_nodes, dtype=np.float64)
    points = np.asarray(rest_points, dtype=np.float64)
    centre, up, right = _sections(nodes)
    x = centre @ nodes[:, 0]
    h = hermite(x, points[:, 0])
    weights = h @ centre
    rest_centre_yz = h @ (centre @ nodes[:, 1:])
    offset = points[:, 1:] - rest_centre_yz
    weights += offset[:, :1] * (h @ up) + offset[:, 1:] * (h @ right)
    return np.asarray(weights)


def _sections(nodes: Array) -> tuple[Array, Array, Array]:
    """Weights (7, 23) of the nodes for centre, dorsal and right axis of the seven stations."""
    centre, up, right = (np.zeros((7, 23)) for _ in range(3))
    for station, first in enumerate(RINGS, start=1):
        upper_left, upper_right, lower_right, lower_left = range(first, first + 4)
        centre[station, first : first + 4] = 0.25
        up[station, [upper_left, upper_right]] = 0.5
        up[station, [lower_left, lower_right]] = -0.5
        right[station, [upper_right, lower_right]] = 0.5
        right[station, [upper_left, lower_left]] = -0.5
        up[station] /= up[station] @ nodes[:, 1]
        right[station] /= right[station] @ nodes[:, 2]
    centre[0, 0] = 1.0
    centre[6, [TAIL_UPPER, TAIL_LOWER]] = 0.5
    up[6, [TAIL_UPPER, TAIL_LOWER]] = np.array([1.0, -1.0]) / (
        nodes[TAIL_UPPER, 1] - nodes[TAIL_LOWER, 1]
    )
    # The nose and the tail's edge have no width of their own.
    up[0], right[0], right[6] = up[1], right[1], right[5]
    return centre, up, right


def hermite(stations: Array, x: Array) -> Array:
    """Weights (p, 7) of a C1 cubic through values at decreasing `stations`; linear outside.

    Tangents of parabolas through three stations reproduce linear functions exactly.
    """
    s = -stations
    u = -x
    n = len(s)
    tangent = np.zeros((n, n))
    gap = np.diff(s)
    for k in range(1, n - 1):
        a, b = gap[k - 1], gap[k]
        tangent[k, k - 1] = -b / (a * (a + b))
        tangent[k, k] = (b - a) / (a * b)
        tangent[k, k + 1] = a / (b * (a + b))
    tangent[0, :2] = np.array([-1.0, 1.0]) / gap[0]
    tangent[-1, -2:] = np.array([-1.0, 1.0]) / gap[-1]
    cell = np.clip(np.searchsorted(s, u, side="right") - 1, 0, n - 2)
    t = np.clip((u - s[cell]) / gap[cell], 0.0, 1.0)[:, None]
    beyond = (u - np.clip(u, s[0], s[-1]))[:, None]
    identity = np.eye(n)
    width = gap[cell][:, None]
    weights = (
        (2 * t**3 - 3 * t**2 + 1) * identity[cell]
        + (t**3 - 2 * t**2 + t) * width * tangent[cell]
        + (3 * t**2 - 2 * t**3) * identity[cell + 1]
        + (t**3 - t**2) * width * tangent[cell + 1]
    )
    end = np.where((u < s[0])[:, None], tangent[:1], tangent[-1:])
    return np.asarray(weights + beyond * end)


NODES, NOSE = 23, 0
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


CouplingMethod = Literal["sections", "patches", "tetrahedra"]


class Coupling(NamedTuple):
    """Weights and offsets of p points on the nodes."""

    weights: Array  # (p, 23) of the nodes; rows sum to one
    face: Ints  # (p,) face of the hull whose axes the offset is in
    offset: Array  # (p, 3) cm; zero except for patches


def couple(method: CouplingMethod, rest_nodes: Array, rest_points: Array) -> Coupling:
    """Couple points (p, 3) to nodes (23, 3), both at rest and in the same axes.

    The rings of nodes must be planes of constant x.
    """
    if method == "patches":
        return Coupling(*bind_to_patches(rest_nodes, rest_points))
    weigh = skin_weights if method == "sections" else tetrahedral_weights
    none = np.zeros(rest_points.shape)
    return Coupling(weigh(rest_nodes, rest_points), np.zeros(len(none), np.int32), none)


def place(coupling: Coupling, nodes: Array) -> Array:
    """The points (…, p, 3) for nodes (…, 23, 3), in the axes of the nodes."""
    points = coupling.weights @ nodes
    if coupling.offset.any():
        axes = face_axes(nodes)[..., coupling.face, :, :]
        points = points + (axes @ coupling.offset[:, :, None])[..., 0]
    return np.asarray(points)
