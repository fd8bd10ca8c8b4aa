"""A smooth path through places at given times: a cubic spline with continuous acceleration.

It has the least acceleration (∫|a|² dt) of all curves through its places. It may overshoot between
places that are unevenly spaced for their times.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array


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
