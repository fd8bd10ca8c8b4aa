"""Pre-evaluated tables of clamped uniform B-spline bases (SMC §7.2).

Bodies are quadratic in u and v ("order 3" of SMC, degree plus one). A quadratic is C1, so normals
are continuous. It stays nearer to the control mesh than a cubic, so that levels differ less, and
needs 9 control points per vertex instead of 16. Fins are linear across and quadratic along.

A smooth path through places at given times: a cubic spline with continuous acceleration.

It has the least acceleration (∫|a|² dt) of all curves through its places. It may overshoot between
places that are unevenly spaced for their times.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints


class Curve(NamedTuple):
    """A spline through n places; constant before its first time and after its last, or a loop."""

    times: Array  # (n,) s, ascending
    places: Array  # (n, 3) cm
    velocities: Array  # (n, 3) cm/s, there
    loop: bool  # True if it begins again at its end


def curve_through(times: Array, places: Array, loop: bool = False) -> Curve:
    """The spline through `places` (n, 3) at `times` (n,), at rest at its ends or a `loop`."""
    n, h = len(times), np.diff(times)
    rise = np.diff(places, axis=0) / h[:, None]
    # Equal accelerations on both sides of each place give n linear equations for the velocities.
    matrix, right = np.eye(n), np.zeros((n, 3))
    for i in range(1, n - 1):
        matrix[i, i - 1 : i + 2] = h[i], 2.0 * (h[i - 1] + h[i]), h[i - 1]
        right[i] = 3.0 * (h[i] * rise[i - 1] + h[i - 1] * rise[i])
    if loop:
        matrix[0, -1] = -1.0
        matrix[-1, -1] = 2.0 * (h[-1] + h[0])
        matrix[-1, -2] += h[0]
        matrix[-1, 1] += h[-1]
        right[-1] = 3.0 * (h[0] * rise[-1] + h[-1] * rise[0])
    return Curve(np.asarray(times), np.asarray(places), np.linalg.solve(matrix, right), loop)


def curve_at(curve: Curve, t: float) -> tuple[Array, Array]:
    """Position (3,), cm, and velocity (3,), cm/s, of the curve at `t`."""
    first, last = curve.times[0], curve.times[-1]
    if curve.loop:
        t = first + (t - first) % (last - first)
    elif not first <= t <= last:
        return curve.places[0 if t < first else -1], np.zeros(3)
    i = min(int(np.searchsorted(curve.times, t, side="right")), len(curve.times) - 1) - 1
    h = curve.times[i + 1] - curve.times[i]
    s = (t - curve.times[i]) / h
    (p, q), (v, w) = curve.places[i : i + 2], curve.velocities[i : i + 2]
    # Hermite's cubic as p + s (h v + s (a + s b)).
    a, b = 3.0 * (q - p) - h * (2.0 * v + w), 2.0 * (p - q) + h * (v + w)
    place = p + s * (h * v + s * (a + s * b))
    return place, v + s / h * (2.0 * a + 3.0 * s * b)


DEGREE = 2
TAPS = DEGREE + 1


class Table(NamedTuple):
    """A basis at parameters t: point(t_k) = Σ_j weight[k, j] · control[first[k] + j]."""

    first: Ints  # (k,) the first control point with a weight
    weight: Array  # (k, 3), sum to one
    slope: Array  # (k, 3) derivatives of the weights by t, sum to zero


def basis_table(controls: int, samples: int, degree: int = DEGREE) -> Table:
    """The basis of `controls` points at `samples` even parameters in [0, 1]."""
    return basis_at(controls, np.linspace(0.0, 1.0, samples), degree)


def basis_at(controls: int, t: Array, degree: int = DEGREE) -> Table:
    """The basis of `controls` points at `t` (k,) in [0, 1]; in degree 1 a weight is 0."""
    if degree not in (1, 2) or controls < degree + 1:
        raise ValueError(f"no basis of degree {degree} on {controls} points")
    t = np.asarray(t, np.float64)
    knot = _knots(controls, degree)
    first = np.clip((t * (controls - degree)).astype(np.int64), 0, controls - degree - 1)
    weight, slope = np.ones((len(t), 1)), np.zeros((len(t), 1))
    for d in range(1, degree + 1):
        # The d nonzero functions of degree d - 1; each contributes to two of degree d.
        begin = (first + degree)[:, None] + np.arange(1 - d, 1)
        width = knot[begin + d] - knot[begin]
        rise = (t[:, None] - knot[begin]) / width
        slope = d * (_after(weight / width) - _before(weight / width))
        weight = _after(rise * weight) + _before((1 - rise) * weight)
    missing = ((0, 0), (0, DEGREE - degree))
    return Table(first, np.pad(weight, missing), np.pad(slope, missing))


def decimated(table: Table, kept: Ints | slice) -> Table:
    """A subset of the samples, as coarser levels use (SMC §7.2)."""
    return Table(table.first[kept], table.weight[kept], table.slope[kept])


def dense(table: Table, controls: int) -> Array:
    """The weights as a matrix (k, controls)."""
    matrix = np.zeros((len(table.first), controls + TAPS))
    for tap in range(TAPS):
        matrix[np.arange(len(matrix)), table.first + tap] += table.weight[:, tap]
    return matrix[:, :controls]


def greville(controls: int, degree: int = DEGREE) -> Array:
    """The Greville parameters (controls,), where each control point has most influence."""
    knot = _knots(controls, degree)
    return np.stack([knot[1 + k : 1 + k + controls] for k in range(degree)]).mean(axis=0)


def through(points: Array) -> Array:
    """The control points (n, …) of the spline through `points` (n, …) at `greville`."""
    points = np.asarray(points, np.float64)
    return np.linalg.solve(_at_greville(len(points)), points.reshape(len(points), -1)).reshape(
        points.shape
    )


@cache
def _at_greville(controls: int) -> Array:
    """The points at `greville` as a matrix (controls, controls) over the control points."""
    return dense(basis_at(controls, greville(controls)), controls)


def _knots(controls: int, degree: int) -> Array:
    inner = np.linspace(0.0, 1.0, controls - degree + 1)
    return np.concatenate([np.zeros(degree), inner, np.ones(degree)])


def _after(values: Array) -> Array:
    return np.pad(values, ((0, 0), (1, 0)))


def _before(values: Array) -> Array:
    return np.pad(values, ((0, 0), (0, 1)))
