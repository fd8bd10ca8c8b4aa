"""The submarine on a rail: position and gaze are set by a tour, not by the helm.

The tour sets the pose directly, without thrust, drag and slip. Position and velocity are part of
the state as usual, so fishes, bow wave and seaweed react as to a piloted hull.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.state import Submarine
from subsea.submarine.hull import MAX_PITCH

GAZE = 2.5  # 1/s: it turns like a head, critically damped ...
TURN_RAD_S = math.radians(15.0)  # ... and no faster than is pleasant to watch


class Rail(NamedTuple):
    """The pose of the hull after a tick, in place of a `Helm`."""

    position: Array  # (3,) cm
    velocity: Array  # (3,) cm/s
    angles: tuple[float, float]  # rad, heading and pitch to turn to
    cut: bool = False  # jump there at once, as a film cut


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
    """Put the submarine on a rail between two ticks."""
    submarine.previous_position[:], submarine.previous_angles[:] = before.position, before.angles
    submarine.position[:], submarine.angles[:] = now.position, now.angles
    submarine.velocity[:] = now.velocity
    submarine.rates[:] = 0.0
