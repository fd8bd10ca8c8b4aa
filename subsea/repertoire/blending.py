"""Blend gradual turns with the straight swim, and measure what playback needs of each row.

Frame B is fixed to the head, and the head of a bent body points inwards, by up to 50° from its
way. So that a fish keeps its way as it bends, blended rows have a frame that faces along it.
"""

from typing import NamedTuple

import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.geometry.rotation import Quaternion, about, conjugate, matrix, mixed, multiply, rotate
from subsea.repertoire.schema import Segment

LEVELS = 12  # parts from the straight swim (0) to the recorded gradual turn
TIGHTEST = 14  # level of the tightest turn: bends are small enough to extrapolate a little
STRAIGHT = 1e-3  # rad per frame below which a swim does not turn
EDGE_ROWS = 5  # at the ends of an acyclic segment, over which its speed there is measured


class Blend(NamedTuple):
    """Rows between a straight swim of T rows and its turns: side, level from 1, phase of the swim.

    n = 2 · TIGHTEST · T rows.
    """

    rotation: Array  # (n, 4)
    translation: Array  # (n, 3) cm
    nodes: Array  # (n, 23, 3) cm
    phase: tuple[Ints, Ints]  # (T,) the swim's row of equal phase, for each row of a turn
    facing: tuple[Array, Array]  # (3, 3) rotations of the full turns to the frame of their way


def blend_turns(segments: dict[str, Segment]) -> Blend | None:
    """Mix swim_medium with the two gradual turns at equal phase; None if their beats differ."""
    swim = segments["swim_medium"]
    turns = [segments[f"turn_{side}_gradual"] for side in ("left", "right")]
    rows = len(swim.nodes)
    if any(len(turn.nodes) != rows for turn in turns):
        return None
    rotation, translation, nodes, phase, facing = [], [], [], [], []
    for turn in turns:
        # The turn to the right is a mirror image: half a beat apart.
        gaps = [np.square(np.roll(turn.nodes, k, axis=0) - swim.nodes).sum() for k in range(rows)]
        lag = int(np.argmin(gaps))
        phase.append((np.arange(rows) + lag) % rows)
        q = _facing(turn)
        R = matrix(np.array(q))
        facing.append(R)
        turns_on = [multiply(multiply(q, tuple(M)), conjugate(q)) for M in turn.increment_rotation]
        other = [
            np.roll(table, lag, axis=0)
            for table in (turns_on, turn.increment_translation @ R.T, turn.nodes @ R.T)
        ]
        for level in range(1, TIGHTEST + 1):
            share = level / LEVELS
            pairs = zip(swim.increment_rotation, map(tuple, other[0]), strict=True)
            rotation.append([mixed(a, b, share) for a, b in pairs])
            translation.append((1.0 - share) * swim.increment_translation + share * other[1])
            nodes.append((1.0 - share) * swim.nodes + share * other[2])
    return Blend(
        np.concatenate(rotation),
        np.concatenate(translation),
        np.concatenate(nodes),
        (phase[0], phase[1]),
        (facing[0], facing[1]),
    )


def _facing(turn: Segment) -> Quaternion:
    """The rotation about the dorsal axis that brings the mean way of a cycle to the x axis."""
    ahead, _, across = turn.increment_translation.sum(axis=0)
    return about(0.0, 1.0, 0.0, float(np.arctan2(across, ahead)))


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
    q = multiply(about(1.0, 0.0, 0.0, np.pi / 2), about(1.0, 0.0, 0.0, lean))
    heading, roll = np.empty(rows), np.full(rows, lean)
    for row, turned in enumerate(segment.increment_rotation):
        q = multiply(q, tuple(turned))
        x = rotate(q, (1.0, 0.0, 0.0))
        heading[row] = np.arctan2(x[1], x[0])
        if not segment.cyclic:
            y = rotate(q, (0.0, 1.0, 0.0))
            roll[row] = np.arctan2(y[0] * x[1] - y[1] * x[0], y[2])
    heading = np.unwrap(np.concatenate([[0.0], heading]))[1:]
    turn = float(heading[-1])
    sway = np.zeros(rows)
    if segment.cyclic:
        course = turn / rows * np.arange(1, rows + 1)
        sway = heading - course - (heading - course).mean()
    way = np.linalg.norm(segment.increment_translation, axis=1)
    edge = rows if segment.cyclic else min(EDGE_ROWS, rows)
    return TurningWay(turn, sway, roll, (float(way[:edge].mean()), float(way[-edge:].mean())))
