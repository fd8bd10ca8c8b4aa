"""Solids in the sea: distances of points, and intersections with rays.

A pillar is a row x, y, radius, height of its top: an upright cylinder that goes on below the
seabed. A rock is a row x, y, z, a, b, c, yaw: an ellipsoid turned about the vertical. The seabed
is a height field over a square. Lengths are cm.
"""

import math

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.vector import Vector
from subsea.kernels import kernel


@kernel
def height_at(heights: Array, half_width: float, x: float, y: float) -> float:
    """Height in cm at (x, y); outside the square [-w, w]² that of its edge.

    `heights` is (n, n), row i along y and column j along x, samples from -w to w inclusive.
    """
    n = heights.shape[0]
    step = 2.0 * half_width / (n - 1)
    u = min(max((x + half_width) / step, 0.0), n - 1.0)
    v = min(max((y + half_width) / step, 0.0), n - 1.0)
    j = min(int(u), n - 2)
    i = min(int(v), n - 2)
    a, b = u - j, v - i
    return (
        (1.0 - b) * ((1.0 - a) * heights[i, j] + a * heights[i, j + 1])
        + b * ((1.0 - a) * heights[i + 1, j] + a * heights[i + 1, j + 1])
    )  # fmt: skip


NEVER = math.inf  # the t of a ray that misses
MIDDLE = 1e-9  # of a gradient that vanishes
NEARLY_CM = 0.01  # above rounding errors


@kernel
def from_pillar(pillar: Array, p: Vector) -> tuple[Vector, float]:
    """Outward direction at p and distance from a pillar (cm, negative inside)."""
    dx, dy = p[0] - pillar[0], p[1] - pillar[1]
    away = math.sqrt(dx * dx + dy * dy)
    side, above = away - pillar[2], p[2] - pillar[3]
    outward = (dx / away, dy / away, 0.0) if away > 1e-9 else (1.0, 0.0, 0.0)
    if above <= 0.0 or side <= 0.0:
        if above > side:
            return (0.0, 0.0, 1.0), above
        return outward, side
    distance = math.sqrt(side * side + above * above)
    normal = (outward[0] * side / distance, outward[1] * side / distance, above / distance)
    return normal, distance


@kernel
def from_rock(rock: Array, p: Vector) -> tuple[Vector, float]:
    """Outward direction at p and approximate distance from a rock (cm, negative inside).

    The distance is exact on the surface and to first order beside it.
    """
    return from_turned_rock(rock, math.cos(rock[6]), math.sin(rock[6]), p)


@kernel
def from_turned_rock(rock: Array, c: float, s: float, p: Vector) -> tuple[Vector, float]:
    """`from_rock` with the cosine and sine of the rock's yaw."""
    dx, dy, dz = p[0] - rock[0], p[1] - rock[1], p[2] - rock[2]
    half = (float(rock[3]), float(rock[4]), float(rock[5]))
    (x, y, z), slope, distance = from_ellipsoid(half, (c * dx + s * dy, c * dy - s * dx, dz))
    if slope < MIDDLE:
        return (0.0, 0.0, 1.0), distance
    return ((c * x - s * y) / slope, (s * x + c * y) / slope, z / slope), distance


@kernel
def from_ellipsoid(half: Vector, p: Vector) -> tuple[Vector, float, float]:
    """Outward gradient, its length, and about how far p is from an ellipsoid, in its own axes.

    The distance is exact on the surface and to first order beside it (cm, negative inside). In
    the very middle the gradient vanishes.
    """
    x, y, z = p[0] / half[0], p[1] / half[1], p[2] / half[2]
    scaled = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / half[0], y / half[1], z / half[2]
    slope = math.sqrt(x * x + y * y + z * z)
    distance = scaled * (scaled - 1.0) / slope if slope >= MIDDLE else -min(half)
    return (x, y, z), slope, distance


@kernel
def far_from_rock(rock: Array, p: Vector, gap: float) -> bool:
    """True if p is surely farther from a rock than `gap` (≥ 0) cm, by `from_rock`.

    A cheap test without the rock's rotation, so False for some that are farther.
    """
    x, y, z = p[0] - rock[0], p[1] - rock[1], p[2] - rock[2]
    wide = max(rock[3], rock[4])
    # With s the size of p in half axes and m the shortest of these, the gap is ≥ m (s - 1).
    size = 1.0 + gap / min(rock[3], rock[4], rock[5])
    tall = rock[5] * rock[5]
    wide *= wide
    return (x * x + y * y) * tall + z * z * wide > 1.000001 * size * size * wide * tall


# Heights above which no rock is near are kept for cells of the sea, and for these ranges, cm.
RANGES_CM = (40.0, 120.0, 240.0)
CELLS = 64  # along each side of the sea
SPARE = 1.0001  # above the rounding of `far_from_rock` and of the heights


@kernel
def rock_tops(rocks: Array, half_width: float) -> Array:
    """Heights (r, n, n) float32 above which `far_from_rock` is true of all rocks, cm.

    They are for gaps of up to RANGES_CM (r,) and for n x n cells of the square [-w, w]², rows along
    y; -inf where that is so at any height.
    """
    tops = np.full((len(RANGES_CM), CELLS, CELLS), np.float32(-np.inf))
    for level in range(len(RANGES_CM)):
        for rock in rocks:
            size = SPARE * (1.0 + RANGES_CM[level] / min(rock[3], rock[4], rock[5]))
            wide, top = size * max(rock[3], rock[4]) + 1.0, rock[2] + size * rock[5] + 1.0
            _raise(tops[level], half_width, rock, wide, top)
    return tops


@kernel
def is_far_from_rocks(tops: Array, half_width: float, p: Vector, gap: float) -> bool:
    """True if p is surely farther than `gap` cm from every rock: one look instead of a loop.

    `tops` are those of `rock_tops`. False for many places near rocks and for large gaps.
    """
    level = 0
    while gap > RANGES_CM[level]:
        level += 1
        if level == len(RANGES_CM):
            return False
    side = 2.0 * half_width / CELLS
    x, y = (p[0] + half_width) / side, (p[1] + half_width) / side
    if not (0.0 <= x < CELLS and 0.0 <= y < CELLS):
        return False
    return bool(p[2] > tops[level, int(y), int(x)])


@kernel
def misses_rocks(tops: Array, half_width: float, a: Vector, b: Vector) -> bool:
    """True if the straight way from a to b surely meets no rock, by a look at each part of it."""
    way = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    length = math.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    parts = int(length / (2.0 * RANGES_CM[1])) + 1
    for part in range(parts):
        share = (part + 0.5) / parts
        middle = (a[0] + share * way[0], a[1] + share * way[1], a[2] + share * way[2])
        if not is_far_from_rocks(tops, half_width, middle, 0.5 * length / parts):
            return False
    return True


# Heights above which nothing at all stands are kept for finer cells, and for these distances, cm.
REACHES_CM = (40.0, 160.0)
SQUARES = 128  # along each side of the sea
ROOM_CM = 1.0  # above the rounding of rays and of the heights


@kernel
def skyline_of(heights: Array, half_width: float, pillars: Array, rocks: Array) -> Array:
    """Heights (r, n, n) float32 above which nothing stands within a level distance, cm.

    Neither pillars (k, 4) and rocks (k, 7) nor the seabed `heights` (m, m) reach above them within
    REACHES_CM (r,) of any point of a cell. The n x n cells cover the square [-w, w]², rows along y.
    """
    skyline = np.empty((len(REACHES_CM), SQUARES, SQUARES), np.float32)
    side, step = 2.0 * half_width / SQUARES, 2.0 * half_width / (len(heights) - 1)
    for level in range(len(REACHES_CM)):
        reach = REACHES_CM[level] + ROOM_CM
        first, last = np.empty(SQUARES, np.int64), np.empty(SQUARES, np.int64)  # samples of a cell
        for cell in range(SQUARES):
            first[cell] = max(int((cell * side - reach) / step), 0)
            last[cell] = min(int(((cell + 1) * side + reach) / step) + 1, len(heights) - 1)
        for row in range(SQUARES):
            for column in range(SQUARES):
                top = -np.inf
                for i in range(first[row], last[row] + 1):
                    for j in range(first[column], last[column] + 1):
                        top = max(top, heights[i, j])
                skyline[level, row, column] = top + ROOM_CM
        for pillar in pillars:
            _raise(skyline[level], half_width, pillar, pillar[2] + reach, pillar[3] + ROOM_CM)
        for rock in rocks:
            wide, top = max(rock[3], rock[4]), rock[2] + rock[5]
            _raise(skyline[level], half_width, rock, wide + reach, top + ROOM_CM)
    return skyline


@kernel
def _raise(tops: Array, half_width: float, middle: Array, wide: float, top: float) -> None:
    """Raise `tops` (n, n) to `top` in all cells within `wide` cm of x and y of a `middle`."""
    n = len(tops)
    side = 2.0 * half_width / n
    west = int(min(max((middle[0] - wide + half_width) / side, 0.0), n))
    east = int(min(max((middle[0] + wide + half_width) / side + 1.0, 0.0), n))
    south = int(min(max((middle[1] - wide + half_width) / side, 0.0), n))
    north = int(min(max((middle[1] + wide + half_width) / side + 1.0, 0.0), n))
    for row in range(south, north):
        for column in range(west, east):
            tops[row, column] = max(tops[row, column], np.float32(top))


@kernel
def is_over_all(skyline: Array, half_width: float, p: Vector, reach: float) -> bool:
    """True if surely no pillar, rock or seabed is within `reach` cm of p, by one look.

    `skyline` is that of `skyline_of`. False for many places near solids and for large reaches.
    """
    if reach > REACHES_CM[1]:
        return False
    level = 0 if reach <= REACHES_CM[0] else 1
    return _is_above(skyline[level], half_width, p, p[2] - reach)


@kernel
def _is_above(tops: Array, half_width: float, p: Vector, lowest: float) -> bool:
    """True if a height is above `tops` (n, n) at x and y of p; False beyond their square."""
    n = len(tops)
    per_cm = 0.5 * n / half_width
    x, y = (p[0] + half_width) * per_cm, (p[1] + half_width) * per_cm
    return bool(0.0 <= x < n and 0.0 <= y < n and lowest > tops[int(y), int(x)])


@kernel
def passes_over_all(skyline: Array, half_width: float, a: Vector, b: Vector) -> bool:
    """True if the straight way from a to b surely meets no pillar, rock or seabed, by few looks.

    `skyline` is that of `skyline_of`. A long part that may meet something is looked at again in
    shorter ones. False for many ways near solids that meet none.
    """
    level = math.sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]))
    parts = int(level / (2.0 * REACHES_CM[1])) + 1
    pieces = int(level / parts / (2.0 * REACHES_CM[0])) + 1
    for part in range(parts):
        if _part_is_above(skyline[1], half_width, a, b, (part, parts)):
            continue
        for piece in range(part * pieces, (part + 1) * pieces):
            if not _part_is_above(skyline[0], half_width, a, b, (piece, parts * pieces)):
                return False
    return True


@kernel
def _part_is_above(
    tops: Array, half_width: float, a: Vector, b: Vector, part: tuple[int, int]
) -> bool:
    """True if a part of the way from a to b, its number and that of all, is above `tops` (n, n)."""
    share, half = (part[0] + 0.5) / part[1], 0.5 / part[1]
    way = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    middle = (a[0] + share * way[0], a[1] + share * way[1], a[2] + share * way[2])
    return _is_above(tops, half_width, middle, middle[2] - half * abs(way[2]))


@kernel
def ray_meets_pillar(pillar: Array, margin: float, a: Vector, b: Vector) -> float:
    """The t at which a + t (b - a), t in [0, 1], enters a pillar enlarged by `margin` cm.

    0 if a lies inside, NEVER if the ray misses. The intervals inside the circle and below the top
    must overlap (Tu §6.4.1): unlike his test this holds for rays through the top, and for those
    that begin or end inside.
    """
    x, y = a[0] - pillar[0], a[1] - pillar[1]
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    first, last = _inside_ball(dx * dx + dy * dy, x * dx + y * dy, x * x + y * y,
                               pillar[2] + margin)  # fmt: skip
    above = a[2] - (pillar[3] + margin)
    if dz == 0.0:
        return first if above <= 0.0 and first <= last else NEVER
    if dz < 0.0:
        first = max(first, -above / dz)
    else:
        last = min(last, -above / dz)
    return first if first <= last else NEVER


@kernel
def ray_meets_rock(rock: Array, margin: float, a: Vector, b: Vector) -> float:
    """The t at which a + t (b - a), t in [0, 1], enters a rock with half axes longer by `margin`.

    0 if a lies inside, NEVER if the ray misses.
    """
    # Reject most rocks by an upright box before the rotation.
    wide, tall = max(rock[3], rock[4]) + margin + NEARLY_CM, rock[5] + margin + NEARLY_CM
    for axis in range(3):
        reach = wide if axis < 2 else tall
        if min(a[axis], b[axis]) - rock[axis] > reach or rock[axis] - max(a[axis], b[axis]) > reach:
            return NEVER
    c, s = math.cos(rock[6]), math.sin(rock[6])
    wx, wy, wz = rock[3] + margin, rock[4] + margin, rock[5] + margin
    px, py, pz = a[0] - rock[0], a[1] - rock[1], a[2] - rock[2]
    x, y, z = (c * px + s * py) / wx, (c * py - s * px) / wy, pz / wz
    ex, ey, ez = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    dx, dy, dz = (c * ex + s * ey) / wx, (c * ey - s * ex) / wy, ez / wz
    first, last = _inside_ball(
        dx * dx + dy * dy + dz * dz, x * dx + y * dy + z * dz, x * x + y * y + z * z, 1.0
    )
    return first if first <= last else NEVER


@kernel
def _inside_ball(dd: float, xd: float, xx: float, radius: float) -> tuple[float, float]:
    """Interval of t in [0, 1] with |x + t d| ≤ radius from d·d, x·d and x·x; (1, 0) if empty."""
    inside = xx - radius * radius
    if dd < 1e-18:
        return (0.0, 1.0) if inside <= 0.0 else (1.0, 0.0)
    square = xd * xd - dd * inside
    if square < 0.0:
        return 1.0, 0.0
    root = math.sqrt(square)
    first, last = max((-xd - root) / dd, 0.0), min((-xd + root) / dd, 1.0)
    return (first, last) if first <= last else (1.0, 0.0)


@kernel
def ray_meets_seabed(
    heights: Array, half_width: float, clearance: float, a: Vector, b: Vector
) -> float:
    """The t at which a + t (b - a), t in [0, 1], comes within `clearance` cm of the seabed.

    0 if a lies there, NEVER if the ray misses. The ray is followed from grid line to grid line;
    between two lines the height above a bilinear field is a parabola in t.
    """
    step = 2.0 * half_width / (heights.shape[0] - 1)
    u, v = (a[0] + half_width) / step, (a[1] + half_width) / step
    du, dv = (b[0] - a[0]) / step, (b[1] - a[1]) / step
    before = _above(heights, half_width, a, b, 0.0) - clearance
    if before <= 0.0:
        return 0.0
    t = 0.0
    while t < 1.0:
        end = min(_next_line(u, du, t), _next_line(v, dv, t), 1.0)
        middle = _above(heights, half_width, a, b, 0.5 * (t + end)) - clearance
        after = _above(heights, half_width, a, b, end) - clearance
        share = _first_root(before, middle, after)
        if share <= 1.0:
            return t + share * (end - t)
        before, t = after, end
    return NEVER


@kernel
def _above(heights: Array, half_width: float, a: Vector, b: Vector, t: float) -> float:
    """Height above the seabed at a + t (b - a)."""
    x, y = a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])
    return a[2] + t * (b[2] - a[2]) - height_at(heights, half_width, x, y)


@kernel
def _next_line(u: float, du: float, t: float) -> float:
    """The first t beyond `t` at which u + t du is a whole number."""
    if du == 0.0:
        return NEVER
    here = u + (t + 1e-9) * du
    line = math.floor(here) + 1.0 if du > 0.0 else math.ceil(here) - 1.0
    return max((line - u) / du, t + 1e-9)


@kernel
def _first_root(before: float, middle: float, after: float) -> float:
    """First root in [0, 1] of the parabola through three values, the first above 0."""
    a = 2.0 * (before + after) - 4.0 * middle
    b = after - before - a
    square = b * b - 4.0 * a * before
    if square < 0.0:
        return NEVER
    # The stable form, also for a straight line.
    low = -b + math.sqrt(square)
    if low > 0.0:
        share = 2.0 * before / low
        if share <= 1.0:
            return share
    return 1.0 if after <= 0.0 else NEVER
