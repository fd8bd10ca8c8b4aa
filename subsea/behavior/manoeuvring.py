"""Manoeuvre close to another fish: turn hard, slow down, hover.

Recorded motion limits how fast a fish turns and climbs (SMC §6.2).
"""

import numpy as np

from subsea.behavior.chasing import set_urge
from subsea.geometry.rotation import rotate, x_axis
from subsea.geometry.vector import Vector, norm, plus, vector
from subsea.kernels import kernel
from subsea.state import Fishes, Minds

CLOSE_RAD = np.radians(40.0)  # wanted angle at which a fish turns fastest
TURNING_RAD, TURNING_SPEED = np.radians((15.0, 45.0, 90.0)), np.array((1.0, 0.35, 0.1))
BELLY_BACK_BL, BELLY_DOWN = 0.05, 0.45  # the abdomen: lengths behind, heights below the origin
SCULL_GAIN = 2.5  # 1/s: share of a gap that fins close in a second


@kernel
def steer(fishes: Fishes, minds: Minds, i: int, toward: Vector) -> float:
    """Turn as hard as the motor system can; returns the angle left, rad.

    At CLOSE_RAD recorded turns and careful alignment add up. A sharp turn, asked for at wider
    angles, turns less in a second.
    """
    turn = turn_to(fishes, i, toward)
    bend(fishes, minds, i, toward, min(max(turn, -CLOSE_RAD), CLOSE_RAD))
    return float(abs(turn))


@kernel
def careful(turn: float) -> float:
    """The share of its speed that a fish keeps while it has to turn by `turn` rad.

    Turning on the spot, it faces a target inside its turning circle and does not orbit it.
    """
    if turn <= TURNING_RAD[0]:
        return TURNING_SPEED[0]
    # By hand: np.interp takes seconds to compile.
    for k in range(len(TURNING_RAD) - 1):
        if turn < TURNING_RAD[k + 1]:
            slope = (TURNING_SPEED[k + 1] - TURNING_SPEED[k]) / (
                TURNING_RAD[k + 1] - TURNING_RAD[k]
            )
            return slope * (turn - TURNING_RAD[k]) + TURNING_SPEED[k]
    return TURNING_SPEED[-1]


@kernel
def hover(fishes: Fishes, minds: Minds, i: int, slope: float) -> None:
    """Hover on the present heading, with the head raised by `slope`."""
    heading = heading_of(fishes, i)
    set_urge(minds, i, (np.cos(heading), np.sin(heading), slope))
    fishes.goal_speed[i] = 0.0


@kernel
def bend(fishes: Fishes, minds: Minds, i: int, toward: Vector, turn: float) -> None:
    """Set the urge to turn left by `turn` rad, and to climb or dive along `toward`."""
    level = np.sqrt(toward[0] * toward[0] + toward[1] * toward[1])
    course = heading_of(fishes, i) + turn
    set_urge(minds, i, (level * np.cos(course), level * np.sin(course), 1.0 * toward[2]))


@kernel
def turn_to(fishes: Fishes, i: int, toward: Vector) -> float:
    """The angle, rad, by which fish i would have to turn left to head along `toward`."""
    return wrapped(np.arctan2(toward[1], toward[0]) - heading_of(fishes, i))


@kernel
def heading_of(fishes: Fishes, i: int) -> float:
    """The heading of the body, rad left of the world's x axis."""
    x = x_axis(fishes.orientation[i])
    return float(np.arctan2(x[1], x[0]))


@kernel
def wrapped(angle: float) -> float:
    """The angle wrapped to between -π and π."""
    return float(angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)))


@kernel
def tail_of(fishes: Fishes, j: int) -> Vector:
    """The tail of fish j with a straight body, cm, world."""
    along = fishes.snout[j] - fishes.length[j]
    return plus(vector(fishes.position[j]), rotate(fishes.orientation[j], (along, 0.0, 0.0)))


@kernel
def abdomen_of(fishes: Fishes, j: int) -> Vector:
    """The belly of fish j, cm, world."""
    length = fishes.length[j]
    offset = (-BELLY_BACK_BL * length, -BELLY_DOWN * fishes.girth[j, 0], 0.0)
    return plus(vector(fishes.position[j]), rotate(fishes.orientation[j], offset))


@kernel
def scull(fishes: Fishes, i: int, way: Vector, most_bl_s: float) -> None:
    """Move fish i by its paired fins along `way`, cm, at no more than `most_bl_s` lengths per s.

    Fishes that hover correct their place so, in any direction and without a beat of the tail.
    """
    gap = norm(way)
    if gap > 1e-6:
        speed = min(SCULL_GAIN * gap, most_bl_s * float(fishes.length[i])) / gap
        for axis in range(3):
            fishes.drift[i, axis] += np.float32(speed * way[axis])
