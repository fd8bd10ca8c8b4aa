"""3-vectors as tuples, for compiled kernels.

Tuples live in registers; small arrays for intermediate results cost twenty times as much as the
arithmetic.
"""

import math

from subsea.base.arrays import Array
from subsea.kernels import kernel

Vector = tuple[float, float, float]

ZERO: Vector = (0.0, 0.0, 0.0)


@kernel
def vector(row: Array) -> Vector:
    """Three numbers of any precision as a vector."""
    return float(row[0]), float(row[1]), float(row[2])


@kernel
def store(row: Array, values: tuple[float, ...]) -> None:
    """Write a vector or quaternion into a row.

    `row[:] = values` would do, but takes numba three seconds to compile, and a copy at each call.
    """
    for k in range(len(values)):
        row[k] = values[k]


@kernel
def plus(a: Vector, b: Vector) -> Vector:
    """The sum a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel
def minus(a: Vector, b: Vector) -> Vector:
    """The difference a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def times(k: float, a: Vector) -> Vector:
    """The vector a, k times as long."""
    return k * a[0], k * a[1], k * a[2]


@kernel
def dot(a: Vector, b: Vector) -> float:
    """The scalar product a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """The vector product a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def norm(a: Vector) -> float:
    """The length of a."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@kernel
def unit(a: Vector) -> Vector:
    """The direction of a, which must not be zero."""
    return times(1.0 / norm(a), a)
