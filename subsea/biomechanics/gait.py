"""Measures of swimming motion, from nodes (T, 23, 3) of T ticks and from muscles."""

import numpy as np

from subsea.biomechanics.body import Body, Floats
from subsea.biomechanics.body_frame import body_frame
from subsea.biomechanics.controllers import muscle_lengths
from subsea.biomechanics.fins import UP

MIN_DISTANCE = 1e-9  # lower bound of a divisor, cm, for a fish that does not swim


def contraction_step(body: Body, contraction: Floats) -> float:
    """Greatest change of a muscle's rest length in one step, cm; the limit is S_MAX."""
    return float(np.abs(np.diff(muscle_lengths(body, contraction), axis=0)).max())


def sweep(frames: Floats, nodes: list[int]) -> float:
    """Peak-to-peak distance of the middle of `nodes` across the path of one beat, cm."""
    chord = (frames[-1] - frames[0]).mean(axis=0)
    aside = np.cross(UP, chord / max(float(np.linalg.norm(chord)), MIN_DISTANCE))
    across = frames[:, nodes].mean(axis=1) @ aside
    drift = np.linspace(0.0, across[-1] - across[0], len(across))
    return float(np.ptp(across - drift))


def snout_bend(frames: Floats) -> float:
    """Greatest angle between the snout and the head behind it, degrees."""
    nose, first, second = frames[:, 0], frames[:, 1:5].mean(axis=1), frames[:, 5:9].mean(axis=1)
    return max(
        _angle(snout, head) for snout, head in zip(nose - first, first - second, strict=True)
    )


def straightness(frames: Floats, ticks_per_beat: int) -> tuple[float, float]:
    """Drift of the heading, degrees, and to the side, cm, over the whole beats of `frames`.

    Heading is the direction of a beat's displacement, first against last; the drift to the side
    is the greatest distance from the line between the ends.
    """
    centres = frames[::ticks_per_beat].mean(axis=1)
    steps = np.diff(centres, axis=0)
    offset = centres - centres[0]
    line = offset[-1] / max(float(np.linalg.norm(offset[-1])), MIN_DISTANCE)
    aside = np.linalg.norm(offset - np.outer(offset @ line, line), axis=1).max()
    return _angle(steps[0], steps[-1]), float(aside)


def headings(frames: Floats) -> Floats:
    """Heading of the body frame in degrees, left positive, without jumps."""
    forward = body_frame(frames)[1][:, :, 0]
    return np.asarray(np.degrees(np.unwrap(np.arctan2(-forward[:, 2], forward[:, 0]))))


def _angle(a: Floats, b: Floats) -> float:
    """Angle between two vectors in degrees."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
