"""Body axes (x anterior, y dorsal, z right) and centimetres as other programs have them."""

import numpy as np

from subsea.core.arrays import Array

METRES = 0.01
# Rows: where each axis points. glTF and USD: x left, y up, z ahead.
Y_UP = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
# The same fish in Blender, which brings glTF's (x, y, z) to (x, -z, y): x left, y back, z up.
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]) @ Y_UP


def to_metres(points: Array, axes: Array) -> Array:
    """Points (..., 3), cm, in metres along other axes."""
    return np.asarray(METRES * (points @ axes.T))


def rotate_quaternions(rotation: Array, axes: Array) -> Array:
    """Quaternions (..., 4), w first, as they are along other axes."""
    return np.concatenate([rotation[..., :1], rotation[..., 1:] @ axes.T], axis=-1)
