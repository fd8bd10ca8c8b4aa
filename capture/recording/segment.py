"""Make a segment of the nodes of a trial: increments and deformation (SMC eqs. 1-9).

Record the segments of a spine-driven species (KS part II).
"""

import numpy as np

from capture.recording.spine_manoeuvre import spine_manoeuvre
from capture.recording.spine_motion import SpineMotion, spine_motion
from subsea.biomechanics.body import Floats, body_frame, to_body
from subsea.biomechanics.solver import TICK_S
from subsea.fish.skinning import Coupling, place
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import SurfacePlan
from subsea.geometry.rotation import from_matrix
from subsea.repertoire import BASIC_SEGMENTS, SEGMENTS, Segment
from subsea.repertoire.schema import ACYCLIC


def make_segment(
    frames: Floats,
    length: float,
    pattern: str,
    grade: str,
    cyclic: bool,
    coupling: Coupling | None = None,
    surface: Floats | None = None,
) -> Segment:
    """The segment of states ``frames`` (T + 1, 23, 3), world axes, cm.

    Row k holds the increment from state k to k + 1 in the body axes of state k, (Rᵏ)ᵀ Rᵏ⁺¹, and
    the deformation at k + 1; SMC eq. 6, in world axes, holds only for the recorded heading. Control
    points come from ``coupling`` (SMC eq. 9) or ``surface`` (T + 1, 426, 3), world axes.
    """
    origin, rotation = body_frame(frames)
    turn = np.swapaxes(rotation[:-1], -1, -2) @ rotation[1:]
    step = np.einsum("tji,tj->ti", rotation[:-1], np.diff(origin, axis=0))
    nodes = to_body(frames, origin, rotation)
    points = None if coupling is None else place(coupling, nodes)
    if surface is not None:
        points = to_body(surface, origin, rotation)
    reach = nodes if surface is None else np.concatenate([nodes, points], axis=1)
    # A cycle sways about its path and ends in its first pose: the path is the chord.
    path = origin[[0, -1]] if cyclic else origin
    distance = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    return Segment(
        pattern=pattern,
        grade=grade,
        cyclic=cyclic,
        increment_rotation=from_matrix(turn),
        increment_translation=step,
        nodes=nodes[1:],
        control_points=None if points is None else points[1:],
        speed_cm_s=float(distance / (len(step) * TICK_S)),
        turn_deg=heading_change(rotation[0], rotation[-1]),
        loop_error_bl=float(np.linalg.norm(nodes[-1] - nodes[0], axis=1).max() / length),
        bounding_radius_bl=float(np.linalg.norm(reach, axis=2).max() / length),
    )


def heading_change(before: Floats, after: Floats) -> float:
    """Change of heading between rotations (3, 3), degrees, left positive.

    Measured about the dorsal axis of ``before``.
    """
    forward = before.T @ after[:, 0]
    return float(np.degrees(np.arctan2(-forward[2], forward[0])))


GLIDES = ("turn_left_glide", "turn_right_glide")


def spine_segments(plan: SpinePlan) -> tuple[str, ...]:
    """The segments of a species, in the order of SEGMENTS.

    A ray never rests, and does not row. Without water there are only the basic ones.
    """
    if plan.medium.slip is not None:
        return BASIC_SEGMENTS
    if plan.wings:
        names = {*BASIC_SEGMENTS, *GLIDES, "swim_burst"}
    else:
        names = set(SEGMENTS) - {"row_forward"}
    if plan.burst is None:
        names -= {"swim_burst"}
    return tuple(name for name in SEGMENTS if name in names)


def record_spine_segment(plan: SpinePlan, surface: SurfacePlan, name: str) -> Segment:
    """Record the segment ``name`` with control points: 23 nodes are too few for eels and rays."""
    _, _, grade = name.rpartition("_")
    motion = motion_of_segment(plan, surface, name)
    return make_segment(
        motion.nodes,
        plan.length,
        pattern="left" if "left" in name else "right" if "right" in name else "forward",
        grade=grade,
        cyclic=grade not in ACYCLIC,
        surface=motion.points,
    )


def motion_of_segment(plan: SpinePlan, surface: SurfacePlan, name: str) -> SpineMotion:
    """Compute all frames of a segment: along a path, or free."""
    _, _, grade = name.rpartition("_")
    free = grade in ACYCLIC and grade != "sharp" and not plan.wings
    return (spine_manoeuvre if free else spine_motion)(plan, surface, name)
