"""View-frustum culling, and projected sizes (SMC §7.1)."""

from collections.abc import Sequence
from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.view.camera import View

OUT_OF_SIGHT = -1.0  # instead of pixels
IN_SIGHT = 1.3  # visibilities; fog hides everything beyond
LEAST_PART = 8192  # things for which another thread pays


def pixels_per_radian(view: View) -> float:
    """Pixels per radian near the axis: the geometric mean of across and up."""
    across = float(view.projection[0, 0]) * view.viewport[2] / 2
    up = float(view.projection[1, 1]) * view.viewport[3] / 2
    return sqrt(across * up)


class ViewArrays(NamedTuple):
    """View parameters for kernels, for v views."""

    planes: Array  # (v, 6, 4) of their frusta, see `View.planes`
    eyes: Array  # (v, 3) cm
    scales: Array  # (v,) pixels per radian


def view_arrays(views: Sequence[View]) -> ViewArrays:
    """Return the planes, eyes and scales of views, as arrays that nobody writes to."""
    return _view_arrays(tuple(views))


@lru_cache(maxsize=2)  # several parts of a picture ask for the same
def _view_arrays(views: tuple[View, ...]) -> ViewArrays:
    planes, eyes = np.empty((len(views), 6, 4)), np.empty((len(views), 3))
    for v, view in enumerate(views):
        planes[v], eyes[v] = view.planes, view.eye
    return ViewArrays(planes, eyes, np.array([pixels_per_radian(view) for view in views]))


def coverage(
    centres: Array,
    radii: Array,
    lengths: Array,
    views: ViewArrays,
    reach_cm: float = np.inf,
    culling: bool = True,
) -> tuple[Array, Array]:
    """Pixels (n,) that each of n things covers in its largest view, and distances (v, n) in cm.

    `centres` (n, 3), `radii` (n,) of the bounding spheres and `lengths` (n,) in cm. A view sees a
    thing whose centre lies in the frustum enlarged by the radius and within `reach_cm`. Distances
    are infinite for views that do not see it; pixels are OUT_OF_SIGHT if none does. Without
    `culling` every view sees everything.
    """
    pixels = np.empty(len(centres), np.float32)
    distance = np.empty((len(views.eyes), len(centres)), np.float32)
    spheres = _Spheres(centres, radii, lengths)
    groups = spheres, views, reach_cm, culling, pixels, distance
    share(_cover, np.arange(len(centres)), LEAST_PART, *groups)
    return pixels, distance


class _Spheres(NamedTuple):
    """Things that are culled, as `coverage` takes them."""

    centres: Array
    radii: Array
    lengths: Array


@kernel
def in_frustum(planes: Array, v: int, x: float, y: float, z: float, radius: float) -> bool:
    """True if a sphere reaches into the frustum of view `v`, with `planes` (v, 6, 4)."""
    for p in range(6):  # number by number: rows would be counted references
        away = planes[v, p, 0] * x + planes[v, p, 1] * y + planes[v, p, 2] * z + planes[v, p, 3]
        if away < -radius:
            return False
    return True


@kernel
def eye_distance(views: ViewArrays, v: int, x: float, y: float, z: float) -> float:
    """Distance of a point from the eye of view `v`, cm."""
    eyes = views[1]
    d = np.sqrt((x - eyes[v, 0]) ** 2 + (y - eyes[v, 1]) ** 2 + (z - eyes[v, 2]) ** 2)
    return float(d)


@kernel
def _cover(
    who: Ints, spheres: _Spheres, views: ViewArrays, reach: float, culling: bool,
    pixels: Array, distance: Array,
) -> None:  # fmt: skip
    planes, _, scales = views
    centres, radii, lengths = spheres
    for i in who:
        x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
        pixels[i] = OUT_OF_SIGHT
        for v in range(len(planes)):
            distance[v, i] = np.inf
            if culling and not in_frustum(planes, v, x, y, z, radii[i]):
                continue
            d = eye_distance(views, v, x, y, z)
            if culling and d - radii[i] >= reach:
                continue
            distance[v, i] = d
            pixels[i] = max(pixels[i], lengths[i] / max(d, 1.0) * scales[v])
