"""Plan transitions between segments: the row of entry and the length of the glide.

SMC appendix A glides to the first frame, for a time set by the distance of the tail. Here row and
length minimise the largest change of any node's velocity at both ends of the glide.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.kernels import kernel
from subsea.repertoire.schema import MAX_GLIDE_FRAMES, Segment, Transitions

LEAVING_SHARE = 0.3  # of the rows of a cyclic segment: the gentlest; of an acyclic one: the last
ROUGH = 1.5  # largest change of velocity at such rows over the usual one, unless all are worse
ESCAPES = ("moderate", "wide")
NEARLY = 1.15  # factor within which a change counts as the gentlest
Vector = tuple[float, float, float]


class Kinematics(NamedTuple):
    """t rows of nodes with their velocities, per frame and in body axes."""

    nodes: Array  # (t, 23, 3)
    shift: Array  # (t, 3) of the body frame into each row
    spin: Array  # (t, 3)
    arriving: Array  # (t, 23, 3) of each node into the row
    leaving: Array  # (t, 23, 3) of each node out of it


def plan_transitions(segments: list[Segment]) -> Transitions:
    """The best transitions between all segments of one species."""
    motions = [kinematics_of(segment) for segment in segments]
    usual = [usual_change(motion) for motion in motions]
    starts = np.concatenate([[0], np.cumsum([len(m.nodes) for m in motions])])
    shape = (int(starts[-1]), len(segments))
    entry = np.broadcast_to(starts[:-1], shape).copy()
    frames = np.ones(shape, np.int64)
    leave = np.ones(shape, np.bool_)
    for a, (here, segment) in enumerate(zip(motions, segments, strict=True)):
        # Acyclic segments are entered at their beginning and left near their end.
        late = 0 if segment.cyclic else round((1.0 - LEAVING_SHARE) * len(here.nodes))
        for b, (there, target) in enumerate(zip(motions, segments, strict=True)):
            goals = np.arange(len(there.nodes)) if target.cyclic else np.array([0])
            escape = target.grade in ESCAPES  # may begin at once
            rows = np.arange(0 if escape else late, len(here.nodes))
            best = [gentlest(here, row, there, goals) for row in rows]
            place = starts[a] + rows
            entry[place, b] = [starts[b] + goal for goal, _, _ in best]
            frames[place, b] = [length for _, length, _ in best]
            change = np.array([least for _, _, least in best]) / max(usual[a], usual[b], 1e-12)
            leave[starts[a] : starts[a] + late, b] = False
            leave[starts[a] + rows[rows >= late], b] = _gentle(
                change[rows >= late], LEAVING_SHARE if segment.cyclic else 1.0
            )
    return Transitions(entry, frames, leave)


def _gentle(change: Array, share: float) -> NDArray[np.bool_]:
    """True for the rows that are good for leaving: a share of those with the least change."""
    most = min(float(np.quantile(change, share)), max(ROUGH, NEARLY * float(change.min())))
    return np.asarray(change <= most)


def kinematics_of(segment: Segment) -> Kinematics:
    """The rows of one segment."""
    nodes, shift = segment.nodes, segment.increment_translation
    spin = rotation_vectors(segment.increment_rotation)
    own = np.diff(np.concatenate([nodes[-1:], nodes]), axis=0)
    if not segment.cyclic:
        own[0] = own[1]
    own_after, shift_after, spin_after = (
        np.concatenate([v[1:], v[:1] if segment.cyclic else v[-1:]]) for v in (own, shift, spin)
    )
    return Kinematics(
        np.ascontiguousarray(nodes, np.float64),
        np.ascontiguousarray(shift, np.float64),
        spin,
        node_velocity(own, shift, spin, nodes),
        node_velocity(own_after, shift_after, spin_after, nodes),
    )


def rotation_vectors(quaternions: Array) -> Array:
    """Axis times angle (t, 3) of small rotations."""
    q = np.where(quaternions[:, :1] < 0, -quaternions, quaternions)
    return np.asarray(2.0 * q[:, 1:])


def usual_change(motion: Kinematics) -> float:
    """The largest change of any node's velocity between frames inside the segment."""
    return float(np.linalg.norm(motion.leaving - motion.arriving, axis=2)[:-1].max())


@kernel
def gentlest(here: Kinematics, row: int, there: Kinematics, goals: Ints) -> tuple[int, int, float]:
    """The best goal and length, and the largest change of a node's velocity at its ends.

    Works on plain numbers: small arrays would take 40 times as long.
    """
    best_goal, best_length, least = goals[0], 1, np.inf
    for goal in goals:
        for length in range(1, MAX_GLIDE_FRAMES + 1):
            early, late = 0.5 / length, 1.0 - 0.5 / length
            shift_early = _blended(here.shift[row], there.shift[goal], early)
            spin_early = _blended(here.spin[row], there.spin[goal], early)
            shift_late = _blended(here.shift[row], there.shift[goal], late)
            spin_late = _blended(here.spin[row], there.spin[goal], late)
            largest = 0.0
            for node in range(here.nodes.shape[1] - 1, -1, -1):  # the tail first: it moves most
                a, b = here.nodes[row, node], there.nodes[goal, node]
                own = (b[0] - a[0]) / length, (b[1] - a[1]) / length, (b[2] - a[2]) / length
                first = _jolt(own, shift_early, spin_early, a, here.arriving[row, node])
                last = _jolt(own, shift_late, spin_late, b, there.leaving[goal, node])
                largest = max(largest, first, last)
                if largest >= least:
                    break
            if largest < least:
                best_goal, best_length, least = goal, length, largest
    return best_goal, best_length, np.sqrt(least)


@kernel
def _blended(here: Array, there: Array, share: float) -> Vector:
    """Mix the increments of two rows, as the gliding frame does."""
    kept = 1.0 - share
    return (
        kept * here[0] + share * there[0],
        kept * here[1] + share * there[1],
        kept * here[2] + share * there[2],
    )


@kernel
def _jolt(own: Vector, shift: Vector, spin: Vector, node: Array, recorded: Array) -> float:
    """Square of the change of a node's velocity between the gliding frame and a recorded row."""
    x = own[0] + (shift[0] + (spin[1] * node[2] - spin[2] * node[1])) - recorded[0]
    y = own[1] + (shift[1] + (spin[2] * node[0] - spin[0] * node[2])) - recorded[1]
    z = own[2] + (shift[2] + (spin[0] * node[1] - spin[1] * node[0])) - recorded[2]
    return x * x + y * y + z * z


def node_velocity(own: Array, shift: Array, spin: Array, nodes: Array) -> Array:
    """Velocity (t, 23, 3) of the nodes in the frame's axes: own motion, shift and spin."""
    x, y, z = (spin[:, None, k] for k in range(3))
    turning = np.empty(nodes.shape, np.result_type(spin, nodes))  # np.cross takes thrice as long
    turning[..., 0] = y * nodes[..., 2] - z * nodes[..., 1]
    turning[..., 1] = z * nodes[..., 0] - x * nodes[..., 2]
    turning[..., 2] = x * nodes[..., 1] - y * nodes[..., 0]
    return np.asarray(own + shift[:, None, :] + turning)
