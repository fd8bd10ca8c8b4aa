"""Pectoral fins as the force they exert on the midsection, and balance by them (Tu §4.6.2)."""

import numpy as np

from subsea.biomechanics.body import NODES, RING_LEFT, Floats
from subsea.biomechanics.simulation import State
from subsea.kinematics.frame import body_frame

EDGE_ON = np.pi / 2
"""Orientation at which a fin cuts the water and exerts nothing."""
STEEPEST = np.pi / 4
"""How far a fin turns from edge-on to ascend, descend or balance (Tu §4.6.2)."""
ROLL_GAIN, PITCH_GAIN = 2.0, 6.0
"""Fin angle for each unit of roll and pitch; below one the fish takes many beats to recover."""
UP = np.array([0.0, 1.0, 0.0])
"""Upwards in the world of a simulation, which a fish at rest shares its axes with."""

_SIDE = np.tile(RING_LEFT, 3)  # of nodes 1 to 12, which carry the fins


def pectoral_force(state: State, area: float, left: float, right: float, water: Floats) -> Floats:
    """Force (23, 3) of fins of ``area`` cm² held at ``left`` and ``right`` radians (Tu eq. 4.16).

    π/2 is edge-on; more raises the leading edge and lifts the fish, less presses it down, π
    brakes. Each fin's force is shared by the six midsection nodes on its side.
    """
    rotation = body_frame(state.x)[1]
    midsection = slice(1, 13)
    velocity = state.v[midsection].mean(axis=0) - water
    force = np.zeros((NODES, 3))
    for side, angle in ((1.0, left), (-1.0, right)):
        normal = np.cos(angle) * rotation[:, 0] + np.sin(angle) * rotation[:, 1]
        push = -area * np.linalg.norm(velocity) * (normal @ velocity) * normal
        force[midsection][side == _SIDE] = push / 6.0
    return force


def balance(state: State) -> tuple[float, float]:
    """Left and right fin orientation, in radians, that bring a fish back upright and level."""
    rotation = body_frame(state.x)[1]
    roll = ROLL_GAIN * (rotation[:, 2] @ UP)
    pitch = PITCH_GAIN * (rotation[:, 0] @ UP)
    left, right = np.clip([roll - pitch, -roll - pitch], -STEEPEST, STEEPEST)
    return EDGE_ON + float(left), EDGE_ON + float(right)
