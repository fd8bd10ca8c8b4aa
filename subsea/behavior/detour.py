"""The side on which a schooling fish passes an obstacle (Tu §7.9.2)."""

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.solids import is_far_from_rocks
from subsea.geometry.vector import ZERO, Vector
from subsea.geometry.walls import WALL_CM
from subsea.kernels import kernel
from subsea.state import Sea

LOOK_BL = 12.0  # distance within which a fish plans to pass an obstacle
BERTH_BL = 1.2  # clearance at which it passes
AWAY = 4.0  # weight of an angle that leads away from the wish
HEADROOM_BL = 0.6  # height above or below a rock at which it passes over or under


@kernel
def rocks_in_way(sea: Sea, here: Vector, length: float) -> Array:
    """The rocks (k, 7) that a fish of `length` cm may have to pass: none far from stone, or all."""
    clear = is_far_from_rocks(sea.tops, sea.half_width, here, LOOK_BL * length)
    return sea.rocks[: 0 if clear else len(sea.rocks)]


@kernel
def detour(
    wish: Vector,
    heading: Vector,
    here: Vector,
    length: float,
    pillars: Array,
    rocks: Array,
    direct: float,
) -> Vector:
    """Level unit vector past the pillars and rocks that wish or heading lead into, or ZERO.

    Candidates are the tangents to all solids near `here` that lead into no other solid. A fish of
    `length` cm takes the one with the least turn from `heading`, so that it does not change its
    mind before the obstacle; tangents that lead away from the wish cost more, or it might circle
    for ever. An angle between tangent and wish costs `direct` as much as one of turning. A fish
    that is turning back ignores what lies on its old heading. A rock counts as round, as wide as
    it is long, with its width at the height of the fish.
    """
    nearest, found = np.inf, -1
    onward = wish[0] * heading[0] + wish[1] * heading[1] >= 0.0  # else it is about to turn back
    for k in range(len(pillars) + len(rocks)):
        dx, dy, around, gap = _circle(k, here, length, pillars, rocks)
        if gap < nearest:
            met = onward and _leads_into(heading, dx, dy, around)
            if met or _leads_into(wish, dx, dy, around):
                nearest, found = gap, k
    if found < 0:
        return ZERO
    near, count = np.empty((len(pillars) + len(rocks), 3)), 0
    for k in range(len(near)):
        dx, dy, around, gap = _circle(k, here, length, pillars, rocks)
        if gap < np.inf:
            near[count, 0], near[count, 1], near[count, 2] = dx, dy, around
            count += 1
            if k == found:
                found = count - 1
    best, least = ZERO, np.inf
    for k in range(count):
        for side in (1.0, -1.0):
            way = _tangent(near[k], side)
            off = _turn(wish, way)
            cost = _turn(heading, way) + direct * off + AWAY * max(off - 0.5 * np.pi, 0.0)
            if cost >= least:
                continue
            free = True
            for m in range(count):
                if m != k and _leads_into(way, near[m, 0], near[m, 1], 0.999 * near[m, 2]):
                    free = False
                    break
            if free:
                best, least = way, cost
    if least == np.inf:
        # No free tangent: pass the nearest, on the side the fish is heading to.
        side = 1.0 if near[found, 1] * heading[0] - near[found, 0] * heading[1] <= 0.0 else -1.0
        best = _tangent(near[found], side)
    return best


@kernel
def _circle(
    k: int, here: Vector, length: float, pillars: Array, rocks: Array
) -> tuple[float, float, float, float]:
    """Offset (x, y) of solid k from `here`, its radius with the berth, and the gap to it.

    Rocks follow pillars. The gap is infinite if the solid is at another height or too far away, and
    for the wall of a tank, which no way leads past.
    """
    if k < len(pillars):
        x, y, radius = pillars[k, 0], pillars[k, 1], pillars[k, 2]
        share = 0.0 if here[2] <= pillars[k, 3] and radius < WALL_CM else 1.0
    else:
        rock = rocks[k - len(pillars)]
        x, y, radius = rock[0], rock[1], max(rock[3], rock[4])
        share = max(abs(here[2] - rock[2]) - HEADROOM_BL * length, 0.0) / rock[5]
    dx, dy, look = x - here[0], y - here[1], LOOK_BL * length
    if share >= 1.0 or dx * dx + dy * dy > (radius + look) ** 2:
        return dx, dy, radius, np.inf
    radius *= np.sqrt(1.0 - share * share)
    gap = np.sqrt(dx * dx + dy * dy) - radius
    return dx, dy, radius + BERTH_BL * length, gap if gap <= look else np.inf


@kernel
def _tangent(circle: Array, side: float) -> Vector:
    """Unit vector past a circle (x, y, radius), on its left (1) or right (-1) side."""
    away = max(np.sqrt(circle[0] * circle[0] + circle[1] * circle[1]), 1e-6)
    ux, uy = circle[0] / away, circle[1] / away
    sine = min(circle[2] / away, 1.0)
    cosine = np.sqrt(1.0 - sine * sine)
    sine *= side
    return ux * cosine - uy * sine, uy * cosine + ux * sine, 0.0


@kernel
def _turn(way: Vector, other: Vector) -> float:
    """Angle, rad, between a way and a level unit vector, seen from above."""
    across = way[0] * other[1] - way[1] * other[0]
    return float(abs(np.arctan2(across, way[0] * other[0] + way[1] * other[1])))


@kernel
def _leads_into(way: Vector, dx: float, dy: float, around: float) -> bool:
    """True if a way leads, seen from above, into a circle of radius `around` about (dx, dy)."""
    level = np.sqrt(way[0] * way[0] + way[1] * way[1])
    if level < 1e-6:
        return False
    x, y = way[0] / level, way[1] / level
    return dx * x + dy * y > 0.0 and abs(dy * x - dx * y) < around
