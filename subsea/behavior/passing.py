"""On which side a fish of a school passes what stands in its way (Tu §7.9.2)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.vector import ZERO, Vector

Array = NDArray[np.floating[Any]]

LOOK_BL = 12.0  # so far ahead a fish sees that it has to pass something
BERTH_BL = 1.2  # how far from it a fish means to pass


@njit(cache=True, error_model="numpy")
def past(
    wish: Vector, heading: Vector, here: Vector, length: float, pillars: Array, rocks: Array
) -> Vector:
    """Level unit vector past the nearest pillar or rock that wish or heading lead into, or ZERO.

    It is the tangent on the side to which the fish, `length` cm long at `here`, is heading already,
    so that it never changes its mind before the obstacle. Each fish decides for itself: a school
    that meets an obstacle splits. A rock counts as round, as wide as it is long; under one that is
    high enough above, as in an arch, fishes swim through.
    """
    nearest, found = LOOK_BL * length, False
    px, py, berth = 0.0, 0.0, 0.0
    for k in range(len(pillars) + len(rocks)):
        roof = -np.inf
        if k < len(pillars):
            x, y, radius, top = pillars[k, 0], pillars[k, 1], pillars[k, 2], pillars[k, 3]
        else:
            rock = rocks[k - len(pillars)]
            x, y, radius, top = rock[0], rock[1], max(rock[3], rock[4]), rock[2] + rock[5]
            roof = rock[2] - rock[5] - BERTH_BL * length
        dx, dy = x - here[0], y - here[1]
        gap = np.sqrt(dx * dx + dy * dy) - radius
        if here[2] > top or here[2] < roof or gap > nearest:
            continue
        around = radius + BERTH_BL * length
        if _leads_into(heading, dx, dy, around) or _leads_into(wish, dx, dy, around):
            nearest, px, py, berth, found = gap, dx, dy, around, True
    if not found:
        return ZERO
    away = max(np.sqrt(px * px + py * py), 1e-6)
    ux, uy = px / away, py / away
    sine = min(berth / away, 1.0)
    cosine = np.sqrt(1.0 - sine * sine)
    if uy * heading[0] - ux * heading[1] > 0.0:
        sine = -sine  # its middle is to the left of the heading: pass on the right
    return ux * cosine - uy * sine, uy * cosine + ux * sine, 0.0


@njit(cache=True, error_model="numpy")
def _leads_into(way: Vector, dx: float, dy: float, around: float) -> bool:
    """Whether a way leads, seen from above, into a circle of radius `around` about (dx, dy)."""
    level = np.sqrt(way[0] * way[0] + way[1] * way[1])
    if level < 1e-6:
        return False
    x, y = way[0] / level, way[1] / level
    return dx * x + dy * y > 0.0 and abs(dy * x - dx * y) < around
