"""Swimming close to another fish: turning hard, slowing down for it, standing still.

A fish that plays back recorded motion turns and climbs only so fast (SMC §6.2).
"""

import numpy as np

from subsea.behavior.chasing import set_urge
from subsea.core.kernels import kernel
from subsea.geometry.rotation import rotate, x_axis
from subsea.geometry.vector import Vector, plus, vector
from subsea.state import Fishes, Minds

CLOSE_RAD = np.radians(40.0)  # with recorded turns and careful alignment a fish turns fastest here
TURNING_RAD, TURNING_SPEED = np.radians((15.0, 45.0, 90.0)), np.array((1.0, 0.35, 0.1))
BELLY_BACK_BL, BELLY_DOWN_BL = 0.05, 0.15  # of her abdomen, behind and below her origin


@kernel
def steer(fishes: Fishes, minds: Minds, i: int, toward: Vector) -> float:
    """Turn to what is near as hard as the motor system can; returns the angle left, rad.

    A fish that asks for a sharp turn throws itself round and turns less in a second than one
    that asks for CLOSE_RAD, where recorded turns and careful alignment add up.
    """
    turn = turn_to(fishes, i, toward)
    bend(fishes, minds, i, toward, min(max(turn, -CLOSE_RAD), CLOSE_RAD))
    return float(abs(turn))


@kernel
def careful(turn: float) -> float:
    """The share of its speed that a fish keeps which has to turn by so many rad.

    Who turns on the spot comes to face what lies inside its turning circle, and doesn't orbit it.
    """
    return float(np.interp(turn, TURNING_RAD, TURNING_SPEED))


@kernel
def hover(fishes: Fishes, minds: Minds, i: int, slope: float) -> None:
    """Stand still and keep the heading, with the head up or down by a slope."""
    heading = heading_of(fishes, i)
    set_urge(minds, i, (np.cos(heading), np.sin(heading), slope))
    fishes.goal_speed[i] = 0.0


@kernel
def bend(fishes: Fishes, minds: Minds, i: int, toward: Vector, turn: float) -> None:
    """Want to turn left by `turn` rad, and upward or downward as `toward` leads."""
    level = np.sqrt(toward[0] * toward[0] + toward[1] * toward[1])
    course = heading_of(fishes, i) + turn
    set_urge(minds, i, (level * np.cos(course), level * np.sin(course), toward[2]))


@kernel
def turn_to(fishes: Fishes, i: int, toward: Vector) -> float:
    """The angle, rad, by which fish i would have to turn left to head along `toward`."""
    return wrapped(np.arctan2(toward[1], toward[0]) - heading_of(fishes, i))


@kernel
def heading_of(fishes: Fishes, i: int) -> float:
    """The angle, rad, that the body heads left of the world's x axis."""
    x = x_axis(fishes.orientation[i])
    return float(np.arctan2(x[1], x[0]))


@kernel
def wrapped(angle: float) -> float:
    """The same angle between -π and π."""
    return float(angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)))


@kernel
def tail_of(fishes: Fishes, j: int) -> Vector:
    """Where the tail of fish j is, cm, world, were it straight."""
    along = fishes.snout[j] - fishes.length[j]
    return plus(vector(fishes.position[j]), rotate(fishes.orientation[j], (along, 0.0, 0.0)))


@kernel
def abdomen_of(fishes: Fishes, j: int) -> Vector:
    """Where the belly of fish j is, cm, world."""
    length = fishes.length[j]
    offset = (-BELLY_BACK_BL * length, -BELLY_DOWN_BL * length, 0.0)
    return plus(vector(fishes.position[j]), rotate(fishes.orientation[j], offset))
