"""The content of a warp file of any format, and the views and directions that it is about.

Angles are degrees: heading to the right, then pitch up, then roll clockwise. Other programs have
right-handed axes, x right, y up, z astern; here z is ahead (`flipped`).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.base.validation import convert
from subsea.geometry.rotation import matrix
from subsea.stage.theatre.theatre_file import Angles
from subsea.stage.theatre.warp import mesh, validated, without_invalid
from subsea.view.rig import Warp


class ViewAngles(NamedTuple):
    """Direction and field of a view, in degrees."""

    heading_deg: float  # to the right
    pitch_deg: float  # then up
    roll_deg: float  # then clockwise
    left_deg: float  # usually negative, as down is
    right_deg: float
    down_deg: float
    up_deg: float


def angles_of(view: ViewAngles, distance_cm: float = 300.0) -> Angles:
    """The table `angles` of a view; a UserError names the key that is out of range."""
    angles = {key: round(float(angle), 5) + 0.0 for key, angle in view._asdict().items()}
    return convert(angles | {"distance_cm": float(distance_cm)}, Angles)


def flipped(vectors: Array) -> Array:
    """Vectors (..., 3) with z astern turned into vectors with z ahead, and back."""
    return np.asarray(vectors, np.float64) * [1.0, 1.0, -1.0]


def turned(rotation: Array) -> tuple[float, float, float]:
    """Heading, pitch and roll of a view turned by a right-handed rotation (3, 3), z astern."""
    return heading_pitch_roll(flipped(np.asarray(rotation, np.float64).T * [[1.0], [1.0], [-1.0]]))


def heading_pitch_roll(axes: Array) -> tuple[float, float, float]:
    """Find the angles of a view with axes right, up, ahead (3, 3)."""
    right, _, ahead = axes
    pitch = np.arcsin(np.clip(ahead[1], -1.0, 1.0))
    if abs(ahead[1]) > 1.0 - 1e-9:  # up or down: heading and roll are one turn
        return float(np.degrees(np.arctan2(-right[2], right[0]))), float(np.degrees(pitch)), 0.0
    heading = np.arctan2(ahead[0], ahead[2])
    level = np.array([np.cos(heading), 0.0, -np.sin(heading)])
    roll = np.arctan2(-right @ np.cross(ahead, level), right @ level)
    return float(np.degrees(heading)), float(np.degrees(pitch)), float(np.degrees(roll))


def dome_shares(rays: Array, tilt_deg: float) -> Array:
    """Find the places (n, 2) of rays (n, 3) in a dome's square; `surround.directions` backwards."""
    tilt = np.radians(tilt_deg)
    middle = np.array([0.0, np.cos(tilt), np.sin(tilt)])
    behind = np.array([0.0, np.sin(tilt), -np.cos(tilt)])
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    aside = np.column_stack([unit[:, 0], unit @ behind])
    length = np.linalg.norm(aside, axis=1)
    away = np.arctan2(length, unit @ middle) / (np.pi / 2)
    return np.asarray(0.5 + 0.5 * aside * (away / np.maximum(length, 1e-12))[:, None])


def quaternion_rotation(quaternion: Array) -> Array:
    """The rotation (3, 3) of a quaternion (x, y, z, w) of any length but zero."""
    q = np.asarray(quaternion, np.float64)
    length = np.linalg.norm(q)
    if not 1e-6 < length < 1e6:
        return np.eye(3)
    return matrix(np.roll(q / length, 1))


def turns(axis: int, degrees: float) -> Array:
    """The right-handed rotation (3, 3) about axis 0, 1 or 2."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found = np.eye(3)
    found[i, i], found[i, j], found[j, i], found[j, j] = c, -s, s, c
    return found


class MeasuredMesh(NamedTuple):
    """A warp, and what else its file says of the projector."""

    warp: Warp
    mask: NDArray[np.float32] | None = None  # (h, w, 4) as `rig.DisplayPatch` has it
    view: ViewAngles | None = None  # the view that the mesh bends
    notes: tuple[str, ...] = ()  # a line for each thing that is left out


def strip_triangles(strip: Ints) -> Ints:
    """Triangles (n, 3) of a strip of indices, without those that turn a corner."""
    three = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
    a, b, c = three.T
    return three[(a != b) & (b != c) & (a != c)]


def node_mesh(places: Array, sources: Array, triangles: Ints, where: str) -> Warp:
    """The warp of nodes (n, 2); those that show no part of the picture are left out."""
    shown = without_invalid(np.asarray(sources, np.float64)[None])[0]
    with np.errstate(invalid="ignore"):
        used = ~np.isnan(shown[:, 0]) & np.isfinite(places).all(axis=1)
    triangles = np.asarray(triangles, np.int64).reshape(-1, 3)
    if triangles.size and not (triangles.min() >= 0 and triangles.max() < len(places)):
        raise UserError(f"a triangle of nodes beyond the {len(places)} of its mesh", file=where)
    kept = triangles[used[triangles].all(axis=1)]
    return validated(mesh(places, np.nan_to_num(shown), kept), where)


def numbers_of(words: Sequence[str], count: int, at: str, names: str) -> list[float]:
    """The first `count` words as numbers; else a UserError at `at` that lists `names`."""
    try:
        return [float(words[k]) for k in range(count)]
    except (ValueError, IndexError) as fault:
        raise UserError(f"{at}: expected the numbers {names}") from fault
