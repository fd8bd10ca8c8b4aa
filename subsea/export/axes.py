"""Convert body axes (x anterior, y dorsal, z right) and cm to those of other programs."""

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.rotation import from_matrix

METRES = 0.01
# Rows are the new axes. glTF and USD: x left, y up, z ahead.
Y_UP = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
# Blender converts (x, y, z) of glTF to (x, -z, y): x left, y back, z up.
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]) @ Y_UP


def to_metres(points: Array, axes: Array) -> Array:
    """Points (..., 3) in cm to metres along other axes."""
    return np.asarray(METRES * (points @ axes.T))


def rotate_quaternions(rotation: Array, axes: Array) -> Array:
    """Quaternions (..., 4), w first, to other axes."""
    return np.concatenate([rotation[..., :1], rotation[..., 1:] @ axes.T], axis=-1)


# The world of the dive has z up; rows are the axes of a world with y up: x, z, -y.
WORLD_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def world_rotations(rotation: Array, own: Array | None = None) -> Array:
    """Rotations (..., 4) from own axes to the world of the dive, in a world with y up.

    `own` are the axes of what is rotated, such as `Y_UP` for a fish whose points are in those;
    None: unchanged, as for a camera.
    """
    w, x, y, z = from_matrix(WORLD_Y_UP)
    before = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    if own is not None:
        w, x, y, z = from_matrix(own.T)
        after = np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])
        before = before @ after
    return np.asarray(rotation @ before.T)
