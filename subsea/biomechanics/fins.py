"""Pectoral fins: their force on the midsection, and the controllers that set them.

The five motor controllers are ascend, descend, balance, brake and backward (Tu §4.6.2). Each but
the last returns the orientations of the left and the right fin in radians, for one tick.
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
)
from subsea.biomechanics.body_frame import body_frame
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

_SIDE = np.tile(RING_LEFT, 3)  # of nodes 1 to 12, which carry the fins


def pectoral_force(
    state: BodyState, area: float, left: float, right: float, water: Floats, rowing: float = 0.0
) -> Floats:
    """Force (23, 3) of fins of ``area`` cm² held at ``left`` and ``right`` radians (Tu eq. 4.16).

    π/2 is edge-on; more raises the leading edge and lifts the fish, less presses it down, π
    brakes. Each fin's force is shared by the six midsection nodes on its side. ``rowing``, cm/tu,
    is the speed at which the fins themselves sweep forwards along the body.
    """
    rotation = body_frame(state.x)[1]
    midsection = slice(1, 13)
    velocity = state.v[midsection].mean(axis=0) - water + rowing * rotation[:, 0]
    force = np.zeros((NODES, 3))
    for side, angle in ((1.0, left), (-1.0, right)):
        normal = np.cos(angle) * rotation[:, 0] + np.sin(angle) * rotation[:, 1]
        push = -area * np.linalg.norm(velocity) * (normal @ velocity) * normal
        force[midsection][side == _SIDE] = push / 6.0
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
