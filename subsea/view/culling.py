"""Which fishes are seen, and in what detail (SMC §7.1, §7.3)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.view.camera import View

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

HIDDEN = 255
IN_SIGHT = 1.3  # visibilities; beyond, the fog hides all
# A level is used as long as the fish's length covers at least so many pixels.
TESSELLATED_PX = 190.0
CONTROL_MESH_PX = 60.0


def frustum_planes(view: View) -> Array:
    """The six planes (6, 4) of a view's frustum; a·x + b·y + c·z + d ≥ 0 inside, unit normals."""
    m = view.projection.astype(np.float64) @ view.view.astype(np.float64)
    planes = np.concatenate([m[3] + m[:3], m[3] - m[:3]])
    return np.asarray(planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True))


def pixels_per_radian(view: View) -> float:
    """Pixels that an object of 1 cm at a distance of 1 cm would cover, near the axis."""
    return float(view.projection[1, 1]) * view.viewport[3] / 2


def classify(
    centres: Array, radii: Array, lengths: Array, views: Sequence[View], culling: bool, lod: bool
) -> Ints:
    """The level of detail (n,) uint8 of every fish, HIDDEN if no view sees it.

    `centres` (n, 3), `radii` (n,) of the bounding spheres and `lengths` (n,) in cm. Culling
    takes the centroid against each frustum enlarged by the radius; a fish gets the finest level
    that any view asks for. Without `culling` none is hidden, without `lod` all are at level 0.
    """
    planes = np.stack([frustum_planes(view) for view in views])
    eyes = np.stack([np.asarray(view.eye, np.float64) for view in views])
    scales = np.array([pixels_per_radian(view) for view in views])
    return np.asarray(_classify(centres, radii, lengths, planes, eyes, scales, culling, lod))


@njit(cache=True)
def _classify(
    centres: Array,
    radii: Array,
    lengths: Array,
    planes: Array,
    eyes: Array,
    scales: Array,
    culling: bool,
    lod: bool,
) -> Ints:
    level = np.full(len(centres), HIDDEN, np.uint8)
    for i in range(len(centres)):
        x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
        for v in range(len(planes)):
            inside = True
            if culling:
                for p in range(6):
                    plane = planes[v, p]
                    if plane[0] * x + plane[1] * y + plane[2] * z + plane[3] < -radii[i]:
                        inside = False
                        break
            if not inside:
                continue
            fine = 0
            if lod:
                d = np.sqrt((x - eyes[v, 0]) ** 2 + (y - eyes[v, 1]) ** 2 + (z - eyes[v, 2]) ** 2)
                pixels = lengths[i] / max(d, 1.0) * scales[v]
                if pixels < CONTROL_MESH_PX:
                    fine = 2
                elif pixels < TESSELLATED_PX:
                    fine = 1
            level[i] = min(level[i], fine)
    return level
