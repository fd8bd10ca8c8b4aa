"""What is in sight, and how large it looks (SMC §7.1)."""

from collections.abc import Sequence
from math import sqrt

import numpy as np

from subsea.core.arrays import Array
from subsea.core.kernels import kernel
from subsea.view.camera import View

OUT_OF_SIGHT = -1.0  # in place of the pixels that something covers
IN_SIGHT = 1.3  # visibilities; beyond, the fog hides all


def pixels_per_radian(view: View) -> float:
    """Pixels that an object of 1 cm at a distance of 1 cm would cover, near the axis.

    Where a display stretches pixels, these are the mean of across and up, as its square counts.
    """
    across = float(view.projection[0, 0]) * view.viewport[2] / 2
    up = float(view.projection[1, 1]) * view.viewport[3] / 2
    return sqrt(across * up)


def coverage(
    centres: Array,
    radii: Array,
    lengths: Array,
    views: Sequence[View],
    reach_cm: float = np.inf,
    culling: bool = True,
) -> tuple[Array, Array]:
    """Pixels (n,) that each of n things covers where it covers most, and how far (v, n) it is, cm.

    `centres` (n, 3), `radii` (n,) of the bounding spheres and `lengths` (n,) in cm. For each of the
    v views a centre is compared with the frustum enlarged by the radius, and nothing is seen beyond
    `reach_cm`. What a view does not see is infinitely far from its eye, what none sees covers
    OUT_OF_SIGHT pixels. Without `culling` all is in sight.
    """
    planes = np.stack([view.planes for view in views])
    eyes = np.stack([np.asarray(view.eye, np.float64) for view in views])
    scales = np.array([pixels_per_radian(view) for view in views])
    pixels = np.empty(len(centres), np.float32)
    distance = np.empty((len(views), len(centres)), np.float32)
    _cover(centres, radii, lengths, planes, eyes, scales, reach_cm, culling, pixels, distance)
    return pixels, distance


@kernel
def in_frustum(planes: Array, v: int, x: float, y: float, z: float, radius: float) -> bool:
    """Whether anything of a sphere is on the inner side of all `planes` (v, 6, 4) of view `v`."""
    for p in range(6):  # number by number: rows would be counted references
        away = planes[v, p, 0] * x + planes[v, p, 1] * y + planes[v, p, 2] * z + planes[v, p, 3]
        if away < -radius:
            return False
    return True


@kernel
def _cover(
    centres: Array,
    radii: Array,
    lengths: Array,
    planes: Array,
    eyes: Array,
    scales: Array,
    reach: float,
    culling: bool,
    pixels: Array,
    distance: Array,
) -> None:
    for i in range(len(centres)):
        x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
        pixels[i] = OUT_OF_SIGHT
        for v in range(len(planes)):
            d = np.sqrt((x - eyes[v, 0]) ** 2 + (y - eyes[v, 1]) ** 2 + (z - eyes[v, 2]) ** 2)
            if culling and (d - radii[i] >= reach or not in_frustum(planes, v, x, y, z, radii[i])):
                distance[v, i] = np.inf
                continue
            distance[v, i] = d
            pixels[i] = max(pixels[i], lengths[i] / max(d, 1.0) * scales[v])
