"""Direction and field of a planar view, as calibration programs store it.

Angles are degrees: heading to the right, then pitch up, then roll clockwise. Other programs have
right-handed axes, x right, y up, z astern; here z is ahead (`flipped`).
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.validation import convert
from subsea.stage.theatre.theatre_file import Angles


class ViewAngles(NamedTuple):
    """Direction and field of a view, in degrees."""

    yaw_deg: float  # to the right
    pitch_deg: float  # then up
    roll_deg: float  # then clockwise
    left_deg: float  # usually negative, as down is
    right_deg: float
    down_deg: float
    up_deg: float


def angles_of(view: ViewAngles, distance_cm: float = 300.0) -> Angles:
    """The table `angles` of a view; a UserError names the key that is out of range."""
    yaw, pitch, roll, left, right, down, up = (round(float(angle), 5) + 0.0 for angle in view)
    turns = {"heading_deg": yaw, "pitch_deg": pitch, "roll_deg": roll}
    edges = {"left_deg": left, "right_deg": right, "down_deg": down, "up_deg": up}
    return convert(turns | edges | {"distance_cm": float(distance_cm)}, Angles)


def flipped(vectors: Array) -> Array:
    """Vectors (..., 3) with z astern turned into vectors with z ahead, and back."""
    return np.asarray(vectors, np.float64) * [1.0, 1.0, -1.0]


def turned(rotation: Array) -> tuple[float, float, float]:
    """Heading, pitch and roll of a view turned by a right-handed rotation (3, 3), z astern."""
    right, _, ahead = flipped(np.asarray(rotation, np.float64).T * [[1.0], [1.0], [-1.0]])
    pitch = np.arcsin(np.clip(ahead[1], -1.0, 1.0))
    if abs(ahead[1]) > 1.0 - 1e-9:  # up or down: heading and roll are one turn
        return float(np.degrees(np.arctan2(-right[2], right[0]))), float(np.degrees(pitch)), 0.0
    heading = np.arctan2(ahead[0], ahead[2])
    level = np.array([np.cos(heading), 0.0, -np.sin(heading)])
    roll = np.arctan2(-right @ np.cross(ahead, level), right @ level)
    return float(np.degrees(heading)), float(np.degrees(pitch)), float(np.degrees(roll))


def quaternion_rotation(quaternion: Array) -> Array:
    """The rotation (3, 3) of a quaternion (x, y, z, w) of any length but zero."""
    q = np.asarray(quaternion, np.float64)
    length = np.linalg.norm(q)
    if not 1e-6 < length < 1e6:
        return np.eye(3)
    x, y, z, w = q / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def turns(axis: int, degrees: float) -> Array:
    """The right-handed rotation (3, 3) about axis 0, 1 or 2."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found = np.eye(3)
    found[i, i], found[i, j], found[j, i], found[j, j] = c, -s, s, c
    return found
