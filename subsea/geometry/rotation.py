"""Rotations as unit quaternions (w, x, y, z), body to world, in compiled and numpy form.

Functions on a single rotation are compiled for use inside kernels. They take anything that can be
indexed and return tuples, which live in registers: small arrays would cost twenty times as much
as the arithmetic.
"""

import math

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.vector import Vector
from subsea.kernels import kernel

Quaternion = tuple[float, float, float, float]

SMALL = 0.25  # sine of half an angle below which a short series is exact to rounding


@kernel
def quaternion(row: Array) -> Quaternion:
    """Four numbers of any precision as a quaternion."""
    return float(row[0]), float(row[1]), float(row[2]), float(row[3])


@kernel
def conjugate(q: Quaternion) -> Quaternion:
    """The inverse of the unit quaternion q: world to body."""
    return q[0], -q[1], -q[2], -q[3]


@kernel
def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """The Hamilton product a·b: first b, then a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@kernel
def rotate(q: Quaternion, v: Vector) -> Vector:
    """The vector v turned by the unit quaternion q."""
    tx = 2.0 * (q[2] * v[2] - q[3] * v[1])
    ty = 2.0 * (q[3] * v[0] - q[1] * v[2])
    tz = 2.0 * (q[1] * v[1] - q[2] * v[0])
    return (
        v[0] + q[0] * tx + q[2] * tz - q[3] * ty,
        v[1] + q[0] * ty + q[3] * tx - q[1] * tz,
        v[2] + q[0] * tz + q[1] * ty - q[2] * tx,
    )


@kernel
def x_axis(q: Quaternion) -> Vector:
    """The world direction of the body's x axis: where the snout points."""
    return rotate(q, (1.0, 0.0, 0.0))


@kernel
def normalised(q: Quaternion) -> Quaternion:
    """The quaternion q at unit length."""
    k = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return q[0] * k, q[1] * k, q[2] * k, q[3] * k


@kernel
def mixed(a: Quaternion, b: Quaternion, weight: float) -> Quaternion:
    """Normalised linear mix of the near rotations a and b, at the weight of b."""
    k = 1.0 - weight
    return normalised(
        (
            k * a[0] + weight * b[0],
            k * a[1] + weight * b[1],
            k * a[2] + weight * b[2],
            k * a[3] + weight * b[3],
        )
    )


@kernel
def fraction(q: Quaternion, f: float) -> Quaternion:
    """The power q**f of the rotation q along the shorter arc."""
    sign = -1.0 if q[0] < 0.0 else 1.0
    w, x, y, z = sign * q[0], sign * q[1], sign * q[2], sign * q[3]
    s = x * x + y * y + z * z
    if s < SMALL * SMALL and (-2.0 <= f <= 2.0 or s == 0.0):
        # sin(f·asin s) / s as a series in s² to the seventh order: recorded increments are small.
        g = f * f
        a = (1.0 - g) / 6.0
        b = a * (9.0 - g) / 20.0
        c = b * (25.0 - g) / 42.0
        d = c * (49.0 - g) / 72.0
        k = f * (1.0 + s * (a + s * (b + s * (c + s * d))))
        return math.sqrt(1.0 - k * k * s), k * x, k * y, k * z
    s = math.sqrt(s)
    half = f * math.atan2(s, w)
    k = math.sin(half) / s
    return math.cos(half), k * x, k * y, k * z


@kernel
def about(x: float, y: float, z: float, angle: float) -> Quaternion:
    """The rotation by `angle` radians about the unit axis (x, y, z)."""
    half = 0.5 * angle
    if -SMALL < half < SMALL:
        g = half * half
        s = half * (1.0 - g / 6.0 * (1.0 - g / 20.0 * (1.0 - g / 42.0)))
        c = math.sqrt(1.0 - s * s)
    else:
        s, c = math.sin(half), math.cos(half)
    return c, s * x, s * y, s * z


@kernel
def of_axes(x: Vector, y: Vector, z: Vector) -> Quaternion:
    """The rotation with body axes x, y and z: compiled form of :func:`from_matrix`."""
    w = 1.0 + x[0] + y[1] + z[2]
    a = 1.0 + x[0] - y[1] - z[2]
    b = 1.0 - x[0] + y[1] - z[2]
    c = 1.0 - x[0] - y[1] + z[2]
    most = max(w, a, b, c)
    if w == most:
        q = (w, y[2] - z[1], z[0] - x[2], x[1] - y[0])
    elif a == most:
        q = (y[2] - z[1], a, x[1] + y[0], z[0] + x[2])
    elif b == most:
        q = (z[0] - x[2], x[1] + y[0], b, y[2] + z[1])
    else:
        q = (x[1] - y[0], z[0] + x[2], y[2] + z[1], c)
    return normalised(q)


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

    Starts from the largest of the four components, so it is exact at half turns.
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
