"""Make a segment of the nodes of a trial: increments and deformation (SMC eqs. 1-9).

A trial is the simulation of a segment's motion by muscles.
"""

import numpy as np

from subsea.biomechanics.body import Floats, body_frame, build_body, to_body
from subsea.biomechanics.body_plan import Muscles as Motion
from subsea.biomechanics.coasting import coast
from subsea.biomechanics.controllers import LEFT, RIGHT
from subsea.biomechanics.manoeuvres import manoeuvre, mirrored
from subsea.biomechanics.solver import TICK_S
from subsea.biomechanics.trial import STRAIGHT, Trial, grade_contraction, steady_beat
from subsea.fish.skinning import Coupling, place
from subsea.geometry.rotation import from_matrix
from subsea.repertoire.schema import ACYCLIC, Segment


def steady_contraction(motion: Motion, name: str) -> Floats:
    """Contractions (6 T, 12) of one beat of a segment, or of the beat before a sharp turn."""
    kind, _, grade = name.rpartition("_")
    if kind == "swim":
        return grade_contraction(motion.swim, grade)
    bias = motion.turn.gradual if grade == "gradual" else STRAIGHT
    return grade_contraction(motion.swim, "medium", bias, side_of(name))


def side_of(name: str) -> float:
    """LEFT or RIGHT: the side of a turn, by the name of its segment."""
    return RIGHT if "right" in name else LEFT


def run_trial(motion: Motion, name: str) -> Trial:
    """Simulate the trial of the segment ``name``."""
    kind, _, grade = name.rpartition("_")
    if grade in ACYCLIC:
        return manoeuvre(motion, name)
    if grade == "coast":
        trial = coast(motion, kind != "swim")
        return mirrored(trial) if side_of(name) == RIGHT else trial
    return steady_beat(build_body(motion.body), steady_contraction(motion, name))


def make_segment(
    frames: Floats,
    length: float,
    pattern: str,
    grade: str,
    cyclic: bool,
    coupling: Coupling | None = None,
    surface: Floats | None = None,
    slowing: float = 0.0,
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
        slowing=slowing,
    )


def heading_change(before: Floats, after: Floats) -> float:
    """Change of heading between rotations (3, 3), degrees, left positive.

    Measured about the dorsal axis of ``before``.
    """
    forward = before.T @ after[:, 0]
    return float(np.degrees(np.arctan2(-forward[2], forward[0])))
