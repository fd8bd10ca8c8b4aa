"""Rotations as unit quaternions (w, x, y, z), body to world, in compiled and numpy form.

The functions on single quaternions are compiled so that kernels can call them; they also serve
plain Python. Every function returns new arrays and leaves its arguments alone.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


@njit(cache=True)
def multiply(a: Array, b: Array) -> Array:
    """The Hamilton product a·b, (4,): first b, then a."""
    out = np.empty_like(a)
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    return out


@njit(cache=True)
def rotate(q: Array, v: Array) -> Array:
    """The vector v (3,) turned by the unit quaternion q (4,)."""
    out = np.empty_like(v)
    tx = 2.0 * (q[2] * v[2] - q[3] * v[1])
    ty = 2.0 * (q[3] * v[0] - q[1] * v[2])
    tz = 2.0 * (q[1] * v[1] - q[2] * v[0])
    out[0] = v[0] + q[0] * tx + q[2] * tz - q[3] * ty
    out[1] = v[1] + q[0] * ty + q[3] * tx - q[1] * tz
    out[2] = v[2] + q[0] * tz + q[1] * ty - q[2] * tx
    return out


@njit(cache=True)
def normalised(q: Array) -> Array:
    """The quaternion q (4,) at unit length."""
    norm = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return q / q.dtype.type(norm)


@njit(cache=True)
def fraction(q: Array, f: float) -> Array:
    """The part f of the rotation q: the power q**f along the shorter arc, (4,)."""
    w = q[0]
    x, y, z = q[1], q[2], q[3]
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    s = np.sqrt(x * x + y * y + z * z)
    out = np.empty_like(q)
    if s < 1e-9:
        out[0], out[1], out[2], out[3] = 1.0, f * x, f * y, f * z
        return out
    half = f * np.arctan2(s, w)
    k = np.sin(half) / s
    out[0], out[1], out[2], out[3] = np.cos(half), k * x, k * y, k * z
    return out


@njit(cache=True)
def about(x: float, y: float, z: float, angle: float) -> Array:
    """The rotation by `angle` radians about the unit axis (x, y, z), (4,) float64."""
    s = np.sin(0.5 * angle)
    return np.array([np.cos(0.5 * angle), s * x, s * y, s * z])


def matrix(q: Array) -> Array:
    """Rotation matrices (…, 3, 3) of unit quaternions (…, 4); columns are the body axes."""
    w, x, y, z = np.moveaxis(np.asarray(q), -1, 0)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
        ],
        -2,
    )


def from_matrix(R: Array) -> Array:
    """Unit quaternions (…, 4) with w ≥ 0 of rotation matrices (…, 3, 3).

    Takes the largest of the four components first, so it is exact at half turns too.
    """
    R = np.asarray(R)
    r = {(i, j): R[..., i, j] for i in range(3) for j in range(3)}
    squares = np.stack(
        [
            1 + r[0, 0] + r[1, 1] + r[2, 2],
            1 + r[0, 0] - r[1, 1] - r[2, 2],
            1 - r[0, 0] + r[1, 1] - r[2, 2],
            1 - r[0, 0] - r[1, 1] + r[2, 2],
        ],
        -1,
    )
    wx, wy, wz = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    xy, xz, yz = r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1]
    rows = np.stack(
        [
            np.stack([squares[..., 0], wx, wy, wz], -1),
            np.stack([wx, squares[..., 1], xy, xz], -1),
            np.stack([wy, xy, squares[..., 2], yz], -1),
            np.stack([wz, xz, yz, squares[..., 3]], -1),
        ],
        -2,
    )
    largest = np.argmax(squares, axis=-1)
    q = np.take_along_axis(rows, largest[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(q[..., :1] < 0, -q, q)
