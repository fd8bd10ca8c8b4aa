"""The pose of a fish between two ticks: a mix of two rows."""

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.rotation import matrix, rotate
from subsea.geometry.vector import Vector, plus, store, times, vector
from subsea.kernels import kernel
from subsea.repertoire.library import Library
from subsea.state import Fishes

TAIL_TIPS = 21, 22  # nodes of the upper and lower tail tip
MAX_STEPS = 16  # rows in a tick of a fish with 1/28 of the recorded length, in a burst


@kernel
def pose_at(fishes: Fishes, library: Library, i: int, alpha: float) -> tuple[int, int, float]:
    """Rows a and b and the weight of b for fish i at share `alpha` of the present tick.

    The pose moves from (a, b, w) of the last tick over every row in between to the present
    (a, b, w). Lengths on this path are frames, so a glide over N frames moves as evenly as
    playback.
    """
    a0, b0 = fishes.previous_row_a[i], fishes.previous_row_b[i]
    a1, b1 = fishes.row_a[i], fishes.row_b[i]
    w0, w1 = np.float64(fishes.previous_weight[i]), np.float64(fishes.weight[i])
    if a0 == a1 and b0 == b1:
        return a0, b0, w0 + alpha * (w1 - w0)
    rest = (1.0 - w0) * fishes.previous_span[i]
    steps = _steps(library, b0, a1)
    way = alpha * (rest + steps + w1 * fishes.span[i])
    if way < rest:
        return a0, b0, w0 + way / fishes.previous_span[i]
    way -= rest
    if way >= steps:
        return a1, b1, (way - steps) / fishes.span[i]
    a = b0
    for _ in range(int(way)):
        a = library.follow[a]
    b = a1 if int(way) == steps - 1 else library.follow[a]
    return a, b, way - int(way)


@kernel
def _steps(library: Library, a: int, b: int) -> int:
    """Frames from row a to row b, which may be bent otherwise; 1 if it is in another segment."""
    if max(a, b) >= len(library.follow):  # simulated
        return 0 if a == b else 1
    row = a
    for n in range(MAX_STEPS):
        if row == b or (n > 0 and library.straight[row] == library.straight[b]):
            return n
        row = library.follow[row]
    return 1


def nodes_world(fishes: Fishes, library: Library, i: int) -> Array:
    """Compute the nodes (23, 3) of fish i at the present tick, cm, world (SMC eq. 12)."""
    return _points_world(fishes, library.nodes, i)


def control_points_world(fishes: Fishes, library: Library, i: int) -> Array:
    """Compute the control points (426, 3) of fish i now, cm, world (SMC eq. 13)."""
    return _points_world(fishes, library.control_points, i)


@kernel
def ends_world(fishes: Fishes, nodes: Array, snout: Array, tail: Array) -> None:
    """Set the tip of the snout and the middle of the tail's edge (n, 3) of all fishes, cm, world.

    `nodes` are the library's.
    """
    for i in range(len(fishes.species)):
        here, q = vector(fishes.position[i]), fishes.orientation[i]
        nose, edge = ends(fishes, nodes, i)
        store(snout[i], plus(here, rotate(q, nose)))
        store(tail[i], plus(here, rotate(q, edge)))


@kernel
def ends(fishes: Fishes, nodes: Array, i: int) -> tuple[Vector, Vector]:
    """The tip of the snout and the middle of the tail's edge of fish i, cm, body axes."""
    upper, lower = TAIL_TIPS
    w, a, b = fishes.weight[i], fishes.row_a[i], fishes.row_b[i]
    before, after = fishes.scale[i] * (1.0 - w), fishes.scale[i] * w
    nose = plus(times(before, vector(nodes[a, 0])), times(after, vector(nodes[b, 0])))
    top = plus(times(before, vector(nodes[a, upper])), times(after, vector(nodes[b, upper])))
    bottom = plus(times(before, vector(nodes[a, lower])), times(after, vector(nodes[b, lower])))
    return nose, times(0.5, plus(top, bottom))


def centres_world(fishes: Fishes, nodes: Array, mass: Array) -> Array:
    """Compute the centres of mass (n, 3) of all fishes at the present tick, cm, world.

    `nodes` are the library's, `mass` (S, 23) those of the nodes of each species. A species without
    muscles has no masses: its nodes count alike.
    """
    share = np.where(mass.any(axis=1, keepdims=True), mass, 1.0)
    share = (share / share.sum(axis=1, keepdims=True))[fishes.species]
    before, after = (
        np.einsum("nk,nkx->nx", share, nodes[row]) for row in (fishes.row_a, fishes.row_b)
    )
    weight, scale = fishes.weight[:, None], fishes.scale[:, None]
    body = scale * ((1.0 - weight) * before + weight * after)
    q = fishes.orientation.astype(np.float64)
    across = 2.0 * np.cross(q[:, 1:], body)
    turned = body + q[:, :1] * across + np.cross(q[:, 1:], across)
    return np.asarray(fishes.position + turned)


def _points_world(fishes: Fishes, table: Array, i: int) -> Array:
    w = fishes.weight[i]
    body = (1 - w) * table[fishes.row_a[i]] + w * table[fishes.row_b[i]]
    R = matrix(fishes.orientation[i].astype(np.float64))
    return np.asarray(fishes.position[i] + (fishes.scale[i] * body) @ R.T)
