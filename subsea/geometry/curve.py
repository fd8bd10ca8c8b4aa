"""A smooth way through places at given times: a cubic spline with continuous acceleration.

Of the curves through all of its places it is the one that accelerates least (∫|a|² dt), so a
camera on it moves as if it had weight. Between places that are unevenly far apart for their times
it may swing out: whoever lays one looks where it leads.
"""

from typing import NamedTuple

import numpy as np

from subsea.core.arrays import Array


class Curve(NamedTuple):
    """A spline through n places; constant before its first time and after its last, or a loop."""

    times: Array  # (n,) s, ascending
    places: Array  # (n, 3) cm
    velocities: Array  # (n, 3) cm/s, there
    loop: bool  # begins again where it ends


def curve_through(times: Array, places: Array, loop: bool = False) -> Curve:
    """The spline through `places` (n, 3) at `times` (n,), at rest at both ends.

    With `loop`, for which the last place must be the first, it goes on there without a jolt.
    """
    n, h = len(times), np.diff(times)
    rise = np.diff(places, axis=0) / h[:, None]
    # Equal accelerations on both sides of every place are n linear equations for the velocities.
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
    """Where the curve is at `t` (3,), cm, and its velocity there (3,), cm/s."""
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
