"""Convert body axes (x anterior, y dorsal, z right) and cm to those of other programs."""

import numpy as np

from subsea.core.arrays import Array

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
