"""Views and their matrices; the only module that uses pyrr.

``clip = projection @ view @ (p, 1)`` with column vectors. pyrr uses rows, so its matrices are
transposed here.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from operator import mul

import numpy as np

from subsea.base.arrays import Array

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import pyrr


NEAR_CM = 5.0
FAR_CM = 6000.0


@dataclass(frozen=True, eq=False)
class View:
    """A camera: its viewport and the matrices that map points into it."""

    viewport: tuple[int, int, int, int]  # x, y, width, height in pixels, origin lower left
    view: Array  # (4, 4) world to eye, looking along -z
    projection: Array  # (4, 4) eye to clip
    eye: Array  # (3,) cm, world
    without: int = -1  # the fish whose eye it is, which it does not show

    @cached_property
    def world_to_clip(self) -> Array:
        """The matrix (4, 4) from the world to clip space, in double precision."""
        return np.asarray(self.projection.astype(np.float64) @ self.view.astype(np.float64))

    @cached_property
    def planes(self) -> Array:
        """Planes (6, 4) of the frustum, unit normals: a·x + b·y + c·z + d ≥ 0 inside."""
        m = self.world_to_clip
        planes = np.concatenate([m[3] + m[:3], m[3] - m[:3]])
        return np.asarray(planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True))


def middle_eye(views: Sequence[View]) -> Array:
    """Return the mean position (3,) of the eyes of views, cm."""
    if len(views) == 1:
        return np.asarray(views[0].eye, np.float64)
    return np.asarray(np.mean([view.eye for view in views], axis=0), np.float64)


def look(eye: Array, forward: Array, up: Array) -> Array:
    """The world-to-eye matrix (4, 4) of an eye at `eye` (3,) that looks along `forward`."""
    # Single numbers: numpy takes ten times as long for vectors of three.
    place = np.asarray(eye, np.float64).tolist()
    ahead = _unit(np.asarray(forward, np.float64).tolist())
    side = _unit(cross(ahead, np.asarray(up, np.float64).tolist()))
    above = _unit(cross(side, ahead))
    behind = [-x for x in ahead]
    rows = [[*axis, -sum(map(mul, axis, place))] for axis in (side, above, behind)]
    return np.array([*rows, [0.0, 0.0, 0.0, 1.0]], np.float32)


def _unit(a: list[float]) -> list[float]:
    length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return [a[0] / length, a[1] / length, a[2] / length]


def cross(a: list[float], b: list[float]) -> list[float]:
    """Multiply two vectors; numpy takes ten times as long."""
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def axes_of(heading: float, pitch: float, roll: float = 0.0) -> Array:
    """Rows right, up, ahead (3, 3) after turns in radians to the right, then up, then clockwise."""
    ch, sh, cp, sp = np.cos(heading), np.sin(heading), np.cos(pitch), np.sin(pitch)
    level, above = np.array([ch, 0.0, -sh]), np.array([-sh * sp, cp, -ch * sp])
    cr, sr = np.cos(roll), np.sin(roll)
    ahead = np.array([sh * cp, sp, ch * cp])
    return np.stack([cr * level - sr * above, sr * level + cr * above, ahead])


def off_axis(
    left: float, right: float, bottom: float, top: float, near: float = NEAR_CM, far: float = FAR_CM
) -> Array:
    """A projection (4, 4) through a window with these edges on the near plane, cm."""
    matrix = pyrr.matrix44.create_perspective_projection_from_bounds(
        left, right, bottom, top, near, far, dtype=np.float64
    )
    return np.asarray(matrix.T, dtype=np.float32)


def edge_tangents(projection: Array) -> tuple[float, float, float, float]:
    """Tangents of the angles to the edges of a projection (4, 4): left, right, bottom, top."""
    p = projection.tolist()
    left, right = ((side + p[0][2]) / p[0][0] for side in (-1.0, 1.0))
    bottom, top = ((side + p[1][2]) / p[1][1] for side in (-1.0, 1.0))
    return left, right, bottom, top
