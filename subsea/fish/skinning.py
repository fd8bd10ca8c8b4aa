"""Coupling of the drawn surface to the nodes by one constant matrix per species.

The axes of Tu's patches (§5.4) jump from face to face, so a bent surface creases. Here
cross-sections are interpolated along the body by a C1 cubic. Centre line and axes are linear in the
nodes, hence so are all control points.
"""

import numpy as np

from subsea.base.arrays import Array

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
    h = _hermite(x, points[:, 0])
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


def _hermite(stations: Array, x: Array) -> Array:
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
