"""What is in sight, and how large it looks (SMC §7.1)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.view.camera import View

Array = NDArray[np.floating[Any]]

OUT_OF_SIGHT = -1.0  # in place of the pixels that something covers
IN_SIGHT = 1.3  # visibilities; beyond, the fog hides all


def pixels_per_radian(view: View) -> float:
    """Pixels that an object of 1 cm at a distance of 1 cm would cover, near the axis."""
    return float(view.projection[1, 1]) * view.viewport[3] / 2


def covered(
    centres: Array,
    radii: Array,
    lengths: Array,
    views: Sequence[View],
    reach_cm: float = np.inf,
    culling: bool = True,
) -> tuple[Array, Array]:
    """Pixels (n,) that each of n things covers where it covers most, and how far (n,) it is, cm.

    `centres` (n, 3), `radii` (n,) of the bounding spheres and `lengths` (n,) in cm. What no view
    sees is OUT_OF_SIGHT: views are taken together, a centre is compared with each frustum enlarged
    by the radius, and nothing is seen beyond `reach_cm`. Without `culling` all is in sight.
    """
    planes = np.stack([view.planes for view in views])
    eyes = np.stack([np.asarray(view.eye, np.float64) for view in views])
    scales = np.array([pixels_per_radian(view) for view in views])
    pixels, distance = np.empty(len(centres), np.float32), np.empty(len(centres), np.float32)
    _cover(centres, radii, lengths, planes, eyes, scales, reach_cm, culling, pixels, distance)
    return pixels, distance


@njit(cache=True)
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
        most, nearest = OUT_OF_SIGHT, np.inf
        for v in range(len(planes)):
            d = np.sqrt((x - eyes[v, 0]) ** 2 + (y - eyes[v, 1]) ** 2 + (z - eyes[v, 2]) ** 2)
            nearest = min(nearest, d)
            if culling:
                inside = d - radii[i] < reach
                for p in range(6):
                    if not inside:
                        break
                    plane = planes[v, p]
                    away = plane[0] * x + plane[1] * y + plane[2] * z + plane[3]
                    inside = away >= -radii[i]
                if not inside:
                    continue
            most = max(most, lengths[i] / max(d, 1.0) * scales[v])
        pixels[i], distance[i] = most, nearest
