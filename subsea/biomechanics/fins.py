"""Pectoral fins: their force on the midsection, and the controllers that set them.

The five motor controllers are ascend, descend, balance, brake and backward (Tu §4.6.2). Each but
the last returns the orientations of the left and the right fin in radians, for one tick.

Measures of swimming motion, from nodes (T, 23, 3) of T ticks and from muscles.
"""

import numpy as np

from subsea.base.arrays import Array
from subsea.biomechanics.body import (
    NODES,
    RING_LEFT,
    TRIANGLE_WEIGHTS,
    TRIANGLES,
    Body,
    Floats,
    body_frame,
)
from subsea.biomechanics.controllers import muscle_lengths
from subsea.biomechanics.simulation import BodyState
from subsea.geometry.vector import ZERO, Vector, cross, minus, plus, store, times, vector
from subsea.kernels import kernel

EDGE_ON = np.pi / 2  # orientation at which a fin cuts the water without force
BROADSIDE = np.pi  # orientation at which a fin meets the water with its whole area
STEEPEST = np.pi / 4
"""Angle by which a fin turns from edge-on to ascend, descend or balance (Tu §4.6.2)."""
ROLL_GAIN, PITCH_GAIN = 2.0, 6.0
"""Fin angle per unit of roll and pitch; below one recovery takes many beats."""
UP = np.array([0.0, 1.0, 0.0])
"""Up in the world of a simulation, whose axes are those of a fish at rest."""

MIDSECTION = slice(1, 13)  # nodes that carry the fins ...
_SIDE = np.tile(RING_LEFT, 3)  # ... and their sides


def pectoral_force(
    state: BodyState, area: float, left: float, right: float, water: Floats, rowing: float = 0.0
) -> Floats:
    """Force (23, 3) of fins of ``area`` cm² held at ``left`` and ``right`` radians (Tu eq. 4.16).

    π/2 is edge-on; more raises the leading edge and lifts the fish, less presses it down, π
    brakes. Each fin's force is shared by the six midsection nodes on its side. ``rowing``, cm/tu,
    is the speed at which the fins themselves sweep forwards along the body.
    """
    rotation = body_frame(state.x)[1]
    velocity = state.v[MIDSECTION].mean(axis=0) - water + rowing * rotation[:, 0]
    pushes = []
    for angle in (left, right):
        normal = np.cos(angle) * rotation[:, 0] + np.sin(angle) * rotation[:, 1]
        pushes.append(-area * np.linalg.norm(velocity) * (normal @ velocity) * normal)
    return side_force(np.array(pushes))


def side_force(push: Floats) -> Floats:
    """Forces (23, 3) of ``push`` (2, 3) on the left and the right side of the midsection.

    The nodes of a side share its push.
    """
    force = np.zeros((NODES, 3))
    for side, own in zip((1.0, -1.0), push, strict=True):
        force[MIDSECTION][side == _SIDE] = own / 6.0
    return force


@kernel
def couple_force(x: Array, inertia: Array, axis: Vector, couple: float) -> Array:
    """Forces (23, 3) that turn nodes x (23, 3) together about ``axis`` at ``couple`` rad/tu².

    ``inertia`` (23,) are their masses with the water that moves with them. The forces add up to 0.
    """
    middle, total, force = ZERO, 0.0, np.empty((NODES, 3))
    for node in range(NODES):
        middle = plus(middle, times(inertia[node], vector(x[node])))
        total += inertia[node]
    for node in range(NODES):
        arm = minus(vector(x[node]), times(1.0 / total, middle))
        store(force[node], times(couple * inertia[node], cross(axis, arm)))
    return force


def ascend(state: BodyState, angle: float) -> tuple[float, float]:
    """Left and right fin that make a swimming fish climb at ``angle`` radians, up to π/2.

    Tu's ascend-MC maps the angle to an orientation. Here the lift fades as the fish reaches the
    angle, because a constant one would turn it over. Roll is balanced too.
    """
    rotation = body_frame(state.x)[1]
    roll = ROLL_GAIN * (rotation[:, 2] @ UP)
    lift = PITCH_GAIN * (np.sin(angle) - rotation[:, 0] @ UP)
    left, right = np.clip([lift + roll, lift - roll], -STEEPEST, STEEPEST)
    return EDGE_ON + float(left), EDGE_ON + float(right)


def descend(state: BodyState, angle: float) -> tuple[float, float]:
    """Left and right fin that make a swimming fish dive at ``angle`` radians, up to π/2."""
    return ascend(state, -angle)


def balance(state: BodyState) -> tuple[float, float]:
    """Left and right fin that return a swimming fish to upright and level."""
    return ascend(state, 0.0)


def brake() -> tuple[float, float]:
    """Left and right fin of a braking fish: both broadside."""
    return BROADSIDE, BROADSIDE


def backward(body: Body, area: float, speed: float) -> float:
    """Rowing speed, cm/tu, of fins of ``area`` cm² for a steady retreat at ``speed`` cm/tu.

    It is the ``rowing`` of :func:`pectoral_force` at which broadside fins of a gliding fish balance
    the drag of its hull. Tu assumes a force proportional to the rowing speed; here a fin is a plate
    (Tu eq. 4.3).
    """
    a, b, c = (body.rest[TRIANGLES[:, corner]] for corner in range(3))
    twice = np.cross(b - a, c - a)
    across = twice[:, 0] / np.linalg.norm(twice, axis=1)
    astern = across < 0
    hull = 0.5 * TRIANGLE_WEIGHTS * np.linalg.norm(twice, axis=1) * np.abs(across) ** 2
    return speed * (1.0 + float(np.sqrt(body.drag * hull[astern].sum() / (2.0 * area))))


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


def rolling(frames: Floats) -> float:
    """Roll of the body frame to one side of its mean, degrees."""
    sideways = body_frame(frames)[1][:, :, 2] @ UP
    return float(0.5 * np.ptp(np.degrees(np.arcsin(sideways))))


def _angle(a: Floats, b: Floats) -> float:
    """Angle between two vectors in degrees."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
