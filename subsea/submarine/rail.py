"""A hull on rails: it is where a tour wants it, and turns to where the tour looks.

The path sets the pose itself. Asking the helm for it would add what the machinery cannot do, drag
and slip, to every tour; yet the hull is a body in the sea as ever: its place and velocity are in
the state, so fishes shy, the bow wave pushes and seaweed bends as before a piloted one.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.core.arrays import Array
from subsea.state import Submarine
from subsea.submarine.hull import MAX_PITCH

GAZE = 2.5  # 1/s: it turns as a head does, critically damped ...
TURN_RAD_S = math.radians(15.0)  # ... and never faster than is pleasant to watch


class Rail(NamedTuple):
    """Where the hull is after a tick, in place of a `Helm`."""

    position: Array  # (3,) cm
    velocity: Array  # (3,) cm/s
    angles: tuple[float, float]  # rad, heading and pitch to turn to
    cut: bool = False  # it is there at once, as in a film


def ride(submarine: Submarine, rail: Rail, dt: float) -> None:
    """Advance the submarine by `dt` seconds along its rail, in place."""
    if rail.cut:
        board(submarine, rail, rail)
        return
    submarine.previous_position[:] = submarine.position
    submarine.previous_angles[:] = submarine.angles
    submarine.position[:] = rail.position
    submarine.velocity[:] = rail.velocity
    error = np.array(rail.angles) - submarine.angles
    error[0] = math.remainder(error[0], math.tau)
    stiffness = GAZE**2  # a spring and its damper, solved implicitly: stable at any dt
    rates = (submarine.rates + dt * stiffness * error) / (1.0 + 2.0 * GAZE * dt + stiffness * dt**2)
    submarine.rates[:] = np.clip(rates, -TURN_RAD_S, TURN_RAD_S)
    submarine.angles += dt * submarine.rates
    submarine.angles[1] = np.clip(submarine.angles[1], -MAX_PITCH, MAX_PITCH)


def board(submarine: Submarine, before: Rail, now: Rail) -> None:
    """Put the submarine on rails, at once, between two ticks."""
    submarine.previous_position[:], submarine.previous_angles[:] = before.position, before.angles
    submarine.position[:], submarine.angles[:] = now.position, now.angles
    submarine.velocity[:] = now.velocity
    submarine.rates[:] = 0.0
