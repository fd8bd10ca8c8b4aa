"""Blend turns with their straight swims, and measure what playback needs of each row.

Frame B is fixed to the head, and the head of a bent body points inwards, by up to 50° from its
way. So that a fish keeps its way as it bends, playback turns the head as the bend changes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.geometry.rotation import about, multiply, quaternion, rotate
from subsea.kernels import kernel
from subsea.repertoire.schema import FAMILIES, Segment

LEVELS = 12  # parts from the straight swim (0) to the recorded gradual turn
TIGHTEST = 14  # level of the tightest turn: bends are small enough to extrapolate a little
JOINT = np.repeat(np.arange(5), (9, 4, 4, 4, 2))  # of each node: the stiff head, rings and tail
STRAIGHT = 1e-3  # rad per frame below which a swim does not turn
TAIL_BEAT = "swim_medium"  # that of FAMILIES whose turns differ in phase
EDGE_ROWS = 5  # at the ends of an acyclic segment, over which its speed there is measured


class Blend(NamedTuple):
    """Rows between a straight swim of T rows and its turns: side, level from 1, phase of the swim.

    n = 2 · TIGHTEST · T rows.
    """

    rotation: Array  # (n, 4)
    translation: Array  # (n, 3) cm
    nodes: Array  # (n, 23, 3) cm
    phase: tuple[Ints, Ints]  # (T,) the swim's row of equal phase, for each row of a turn
    facing: tuple[float, float]  # rad, of the head from its way in the full turns, left positive


def blend_turns(segments: dict[str, Segment], straight: str) -> Blend | None:
    """Mix one of `FAMILIES` with its turns at equal phase; None without them or a common beat."""
    names = straight, *FAMILIES[straight]
    if any(name not in segments for name in names):
        return None
    swim, *turns = (segments[name] for name in names)
    rows = len(swim.nodes)
    if any(len(turn.nodes) != rows for turn in turns):
        return None
    # A level of a blend is a whole cycle, and one more axis of all tables.
    share = np.arange(1, TIGHTEST + 1)[:, None, None] / LEVELS
    rotation, translation, nodes, phase, facing = [], [], [], [], []
    for turn in turns:
        # The turn to the right is a mirror image: half a beat of the tail apart.
        lags = range(rows if straight == TAIL_BEAT else 1)
        gaps = [np.square(np.roll(turn.nodes, k, axis=0) - swim.nodes).sum() for k in lags]
        lag = int(np.argmin(gaps))
        phase.append((np.arange(rows) + lag) % rows)
        ahead, _, across = turn.increment_translation.sum(axis=0)
        facing.append(float(np.arctan2(across, ahead)))
        turned, shifted, bent = (
            np.roll(table, lag, axis=0)
            for table in (turn.increment_rotation, turn.increment_translation, turn.nodes)
        )
        rotation.append(_normalised((1.0 - share) * swim.increment_rotation + share * turned))
        translation.append((1.0 - share) * swim.increment_translation + share * shifted)
        nodes.append(_bent(swim.nodes, bent, share))
    return Blend(
        np.concatenate(rotation).reshape(-1, 4),
        np.concatenate(translation).reshape(-1, 3),
        np.concatenate(nodes).reshape(-1, *swim.nodes.shape[1:]),
        (phase[0], phase[1]),
        (facing[0], facing[1]),
    )


def _normalised(q: Array) -> Array:
    """Quaternions (…, 4) at unit length, rounded as by `rotation.normalised`."""
    w, x, y, z = (q[..., k] for k in range(4))
    return np.asarray(q * (1.0 / np.sqrt(w * w + x * x + y * y + z * z))[..., None])


def _bent(swim: Array, turn: Array, share: Array) -> Array:
    """Poses (k, T, 23, 3) that are bent by the k shares (k, 1, 1) of the turn's bend.

    The angles of the body's joints are mixed, seen from above, and with them its lengths and
    heights: mixed coordinates would shorten a bent body.
    """
    (links, rings), (bent_links, bent_rings) = _jointed(swim), _jointed(turn)
    joints = np.cumsum(_turned(links, bent_links, share), axis=-1)[..., JOINT]
    flat = joints + _turned(rings, bent_rings, share)
    height = (1.0 - share) * swim[..., 1] + share * turn[..., 1]
    return np.stack([flat.real, height, flat.imag], axis=-1)


def _jointed(nodes: Array) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Links (T, 5) between joints, the first zero, and nodes (T, 23) from their joint: x + iz.

    The joints are the origin of B, the middles of the three rings behind it, and the tail's.
    """
    flat = nodes[..., 0] + 1j * nodes[..., 2]
    joints = np.zeros((len(flat), JOINT[-1] + 1), np.complex128)
    for joint in range(1, JOINT[-1] + 1):
        joints[:, joint] = flat[:, joint == JOINT].mean(axis=1)
    return np.diff(joints, axis=1, prepend=0.0), flat - joints[:, JOINT]


def _turned(
    a: NDArray[np.complex128], b: NDArray[np.complex128], share: Array
) -> NDArray[np.complex128]:
    """Vectors between a and b at each share: their lengths and angles are mixed."""
    length = (1.0 - share) * np.abs(a) + share * np.abs(b)
    return np.asarray(length * np.exp(1j * (np.angle(a) + share * np.angle(b * a.conj()))))


class TurningWay(NamedTuple):
    """Measures of a segment of t rows, of a fish that begins it upright."""

    turn: float  # rad, change of heading over the segment, left positive
    sway: Array  # (t,) rad, heading of B beyond its mean course: the beat of the head
    bank: Array  # (t,) rad, roll to keep: the mean of a cycle, or that of an acyclic row
    pace: tuple[float, float]  # cm per frame at the beginning and at the end


def course_of(segment: Segment) -> TurningWay:
    """Integrate the increments of a segment."""
    rows = len(segment.nodes)
    spin = 2.0 * segment.increment_rotation[:, 1:] * np.sign(segment.increment_rotation[:, :1])
    mean = spin.mean(axis=0)
    lean = 0.0
    if segment.cyclic and abs(mean[1]) > STRAIGHT:
        # A body that turns about the vertical while it leans by r turns about (0, cos r, -sin r).
        lean = float(np.arctan2(-mean[2] * np.sign(mean[1]), abs(mean[1])))
    x, y = _axes(segment.increment_rotation, lean)
    heading, roll = np.arctan2(x[1], x[0]), np.full(rows, lean)
    if not segment.cyclic:
        roll = np.arctan2(y[0] * x[1] - y[1] * x[0], y[2])
    heading = np.unwrap(np.concatenate([[0.0], heading]))[1:]
    turn = float(heading[-1])
    sway = np.zeros(rows)
    if segment.cyclic:
        course = turn / rows * np.arange(1, rows + 1)
        sway = heading - course - (heading - course).mean()
    way = np.linalg.norm(segment.increment_translation, axis=1)
    edge = rows if segment.cyclic else min(EDGE_ROWS, rows)
    return TurningWay(turn, sway, roll, (float(way[:edge].mean()), float(way[-edge:].mean())))


@kernel
def _axes(increments: Array, lean: float) -> tuple[Array, Array]:
    """Compute body axes x and y (3, t) after each increment (t, 4), from upright with a lean."""
    x, y = np.empty((3, len(increments))), np.empty((3, len(increments)))
    q = multiply(about(1.0, 0.0, 0.0, np.pi / 2), about(1.0, 0.0, 0.0, lean))
    for row in range(len(increments)):
        q = multiply(q, quaternion(increments[row]))
        x[0, row], x[1, row], x[2, row] = rotate(q, (1.0, 0.0, 0.0))
        y[0, row], y[1, row], y[2, row] = rotate(q, (0.0, 1.0, 0.0))
    return x, y
