"""Rock formations: solids that overlap are one weathered stone, given by a signed distance.

The drawn stone, on which corals grow, lies inside what the fishes avoid (`geometry/solids.py`):
by a shell with room for growth, and by the depth of strata, cracks, holes and worn faces.

A formation is an array of blocks (k, 11): x, y, z, half axes a, b, c, cosine and sine of the yaw,
shell, relief and softness, lengths in cm. Of a pillar z is its top, a and b are its radius and c is
infinite.
"""

import math
from zlib import crc32

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.noise import fractal, noise
from subsea.geometry.solids import from_ellipsoid
from subsea.geometry.vector import Vector, store, vector
from subsea.geometry.walls import is_wall
from subsea.kernels import kernel

SHELL_CM, SHELL = 9.0, 0.13  # most room for growth, and as a share of a solid's least half axis
RELIEF_CM, RELIEF = 28.0, 0.32  # depth of the deepest hollow, likewise
BLEND = 0.10  # smoothness between blocks, over the mean least half axis
FAR_CM = 35.0  # how much farther than another a block has no effect
NEAR_CM = FAR_CM + 25.0  # distance of blocks that shape a surface
PROBE_CM = 1.5  # baseline of slopes


def blocks_of(pillars: Array, rocks: Array) -> Array:
    """Rows of `Sea.pillars` (k, 4) and of `Sea.rocks` (m, 7) as blocks (k + m, 11)."""
    out = np.zeros((len(pillars) + len(rocks), 11))
    for row, (x, y, radius, top) in zip(out, pillars, strict=False):
        row[:8] = x, y, top, radius, radius, np.inf, 1.0, 0.0
    rest = out[len(pillars) :]
    rest[:, :6] = rocks[:, :6]
    rest[:, 6], rest[:, 7] = np.cos(rocks[:, 6]), np.sin(rocks[:, 6])
    least = out[:, 3:6].min(axis=1)
    out[:, 8] = np.minimum(SHELL * least, SHELL_CM)
    out[:, 9], out[:, 10] = np.minimum(RELIEF * least, RELIEF_CM), BLEND * least
    return out


def formations(pillars: Array, rocks: Array) -> list[Array]:
    """The blocks of each formation: solids that overlap, directly or through others."""
    return [blocks for blocks, _ in numbered_formations(pillars, rocks)]


def numbered_formations(pillars: Array, rocks: Array) -> list[tuple[Array, Ints]]:
    """The blocks of each formation, and their solids: pillars before rocks."""
    stones = stone_numbers(pillars, rocks)
    blocks = blocks_of(pillars, rocks)[stones]
    group = _groups(blocks, _even(48))
    found: list[tuple[Array, Ints]] = [
        (blocks[group == k], stones[group == k]) for k in np.unique(group)
    ]
    for one, _ in found:
        one[:, 10] = one[:, 10].mean()  # equal, or it would jump between blocks
    return found


def stone_keys(pillars: Array, rocks: Array) -> Ints:
    """A seed (k + m,) for what grows on each solid, by its shape, the same wherever it stands.

    Solids of the same shape are counted, so that each has its own.
    """
    shapes = [np.round(pillars[:, 2:3], 2), np.round(rocks[:, 3:7], 2)]
    seen: dict[int, int] = {}
    keys = []
    for shape in (row for rows in shapes for row in rows):
        key = crc32(shape.tobytes())
        seen[key] = seen.get(key, -1) + 1
        keys.append((key + 0x9E3779B1 * seen[key]) % 2**32)
    return np.array(keys, np.int64)


def first_of_formation(pillars: Array, rocks: Array) -> Ints:
    """The first solid of the formation of each solid (k + m,), pillars before rocks."""
    found = np.arange(len(pillars) + len(rocks))
    for _, numbers in numbered_formations(pillars, rocks):
        found[numbers] = numbers[0]
    return found


def stone_numbers(pillars: Array, rocks: Array) -> Ints:
    """List the solids that are of stone, pillars before rocks: all but walls of glass."""
    return np.flatnonzero(~np.append(is_wall(pillars), np.zeros(len(rocks), np.bool_)))


@kernel
def on_the_surface(blocks: Array, places: Array, steps: int) -> tuple[Array, Array, Array]:
    """Places (n, 3) moved onto the drawn stone, normals, and remaining distances (n,), cm."""
    place, normal, error = places.copy(), np.empty_like(places), np.empty(len(places))
    for i in range(len(places)):
        few = blocks_near(blocks, vector(place[i]), NEAR_CM)
        if len(few) == 0:
            error[i] = np.inf
            continue
        for _ in range(steps):
            p = vector(place[i])
            way, steep = outward(few, p)
            step = drawn_distance(few, p) / max(steep, 0.5)
            for axis in range(3):
                place[i, axis] -= 0.9 * step * way[axis]
        p = vector(place[i])
        store(normal[i], outward(few, p)[0])
        error[i] = abs(drawn_distance(few, p))
    return place, normal, error


@kernel
def drawn_distance(blocks: Array, p: Vector) -> float:
    """Distance of p from the drawn stone, to first order; cm, negative inside."""
    distance, relief = plain_distance(blocks, p)
    return distance + relief * carved(p)


@kernel
def stone_above(blocks: Array, x: float, y: float, z: float) -> float:
    """Height at which a vertical line upward from (x, y, z) leaves the drawn stone."""
    while z < 0.0:
        gap = drawn_distance(blocks, (x, y, z))
        if gap > -0.2:
            break
        z += max(-0.5 * gap, 0.5)
    return z


@kernel
def plain_distance(blocks: Array, p: Vector) -> tuple[float, float]:
    """Distance from the unweathered formation, and the depth of its hollows here."""
    nearest, avoided = np.inf, np.inf
    weight, deep, softness = 0.0, 0.0, blocks[0, 10]
    for k in range(len(blocks)):
        block = blocks[k]
        if _at_least(block, p) > nearest + FAR_CM:
            continue  # too far to have an effect
        outer = _from_block(block, p)
        d = outer + block[8]
        avoided = min(avoided, outer)
        if d < nearest:
            share = math.exp((d - nearest) / softness) if weight > 0.0 else 0.0
            weight, deep, nearest = weight * share + 1.0, deep * share + block[9], d
        else:
            share = math.exp((nearest - d) / softness)
            weight, deep = weight + share, deep + share * block[9]
    # The smooth union exceeds the blocks, but never what fishes avoid.
    return max(nearest - softness * math.log(weight), avoided + 1.0), deep / weight


@kernel
def rough_distance(blocks: Array, p: Vector) -> float:
    """As `plain_distance` with a plain union: enough for shade."""
    nearest = np.inf
    for k in range(len(blocks)):
        if _at_least(blocks[k], p) < nearest:
            nearest = min(nearest, _from_block(blocks[k], p) + blocks[k, 8])
    return nearest


@kernel
def blocks_near(blocks: Array, p: Vector, reach: float) -> Array:
    """The blocks (m, 11) that may lie within `reach` of p."""
    out = np.empty_like(blocks)
    number = 0
    for k in range(len(blocks)):
        if _at_least(blocks[k], p) < reach:
            for column in range(blocks.shape[1]):
                out[number, column] = blocks[k, column]
            number += 1
    return out[:number]


@kernel
def _at_least(block: Array, p: Vector) -> float:
    """Lower bound of the distance from a block, by its box, cm; negative inside."""
    reach = max(block[3], block[4])
    side = max(abs(p[0] - block[0]), abs(p[1] - block[1])) - reach
    above = p[2] - block[2]
    if block[5] == np.inf:
        return max(side, above)
    return max(side, abs(above) - block[5])


@kernel
def _from_block(block: Array, p: Vector) -> float:
    """Distance from a block, as `solids.from_rock`; pillars have a worn outline."""
    dx, dy, dz = p[0] - block[0], p[1] - block[1], p[2] - block[2]
    if block[5] == np.inf:
        # A stack: narrow at the top, waisted, nowhere quite round.
        size = block[3]
        worn = 0.45 * size
        waist = noise(block[0], block[1] + 1.3 * dx / size, dz / (2.1 * size))
        waist += 0.6 * noise(1.1 * dx / size, 1.1 * dy / size + block[1], dz / (1.1 * size))
        lost = size * (0.26 * math.exp(min(dz, 0.0) / (2.2 * size)) + 0.30 * max(waist + 0.1, 0.0))
        side, above = math.sqrt(dx * dx + dy * dy) - size + lost + worn, dz + worn
        if side <= 0.0 or above <= 0.0:
            return max(side, above) - worn
        return math.sqrt(side * side + above * above) - worn
    x, y = block[6] * dx + block[7] * dy, block[6] * dy - block[7] * dx
    return from_ellipsoid((block[3], block[4], block[5]), (x, y, dz))[2]


@kernel
def carved(p: Vector) -> float:
    """Share of the relief that weathering took away at p, 0 to 1, continuous over blocks."""
    x, y, z = p
    bend = noise(x / 140.0 + 3.1, y / 140.0, z / 140.0)
    # Ridges between worn faces, large and small.
    faces = abs(noise(x / 66.0 + bend, y / 66.0, z / 58.0))
    faces += 0.55 * abs(noise(x / 29.0, y / 29.0 + 2.0 * bend, z / 26.0 + 5.5))
    lumps = fractal(x / 92.0, y / 92.0, z / 75.0 + 1.7, 2)
    # Strata: hard layers jut out over soft ones.
    layer = (z + 30.0 * bend + 0.07 * x) / 36.0
    within = layer - math.floor(layer)
    ledge = 1.0 - within if within > 0.16 else 0.84 * within / 0.16
    ledge *= 0.65 + 1.1 * noise(0.7 * math.floor(layer), x / 170.0, y / 170.0)
    crack = abs(noise(x / 74.0, y / 74.0 + 8.5, z / 150.0)) / 0.045
    crack = math.exp(-crack * crack)
    hole = noise(x / 24.0 + 4.4, y / 24.0, z / 24.0)
    hole = min(max((hole - 0.30) / 0.2, 0.0), 1.0)
    gone = 0.06 + 0.95 * faces - 0.30 * lumps + 0.34 * ledge + 0.40 * crack + 0.30 * hole
    return min(max(gone, 0.0), 1.0)


@kernel
def outward(blocks: Array, p: Vector) -> tuple[Vector, float]:
    """Gradient of the distance from the drawn stone: its direction and length, about 1."""
    # From four corners of a tetrahedron.
    a = drawn_distance(blocks, (p[0] + PROBE_CM, p[1] - PROBE_CM, p[2] - PROBE_CM))
    b = drawn_distance(blocks, (p[0] - PROBE_CM, p[1] - PROBE_CM, p[2] + PROBE_CM))
    c = drawn_distance(blocks, (p[0] - PROBE_CM, p[1] + PROBE_CM, p[2] - PROBE_CM))
    d = drawn_distance(blocks, (p[0] + PROBE_CM, p[1] + PROBE_CM, p[2] + PROBE_CM))
    x, y, z = a - b - c + d, -a - b + c + d, -a + b - c + d
    size = math.sqrt(x * x + y * y + z * z)
    if size < 1e-9:
        return (0.0, 0.0, 1.0), 0.0
    return (x / size, y / size, z / size), size / (4.0 * PROBE_CM)


def _even(number: int) -> Array:
    """Directions (n, 3), even over the sphere (Fibonacci spiral)."""
    k = np.arange(number) + 0.5
    z, turn = 1.0 - 2.0 * k / number, np.pi * (1.0 + 5.0**0.5) * k
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1)


@kernel
def _groups(blocks: Array, directions: Array) -> Ints:
    """A group number (k,) that overlapping solids share."""
    group = np.arange(len(blocks))
    for i in range(len(blocks)):
        for j in range(len(blocks)):
            if group[i] != group[j] and _meet(blocks[i], blocks[j], directions):
                old, new = group[i], group[j]
                for k in range(len(blocks)):
                    if group[k] == old:
                        group[k] = new
    return group


@kernel
def _meet(one: Array, other: Array, directions: Array) -> bool:
    """True if a point of the surface or the middle of one block lies inside the other."""
    if one[5] == np.inf:
        if other[5] == np.inf:
            far = one[3] + other[3]
            return (one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2 < far * far
        return False  # tested with the blocks swapped
    reach = max(one[3], one[4], one[5])
    if abs(one[0] - other[0]) > reach + max(other[3], other[4]) + 1.0 and one[5] != np.inf:
        return False
    if _from_block(other, (one[0], one[1], one[2])) < 0.0:
        return True
    for k in range(len(directions)):
        x, y = one[3] * directions[k, 0], one[4] * directions[k, 1]
        p = (
            one[0] + one[6] * x - one[7] * y,
            one[1] + one[7] * x + one[6] * y,
            one[2] + one[5] * directions[k, 2],
        )
        if _from_block(other, p) < 0.0:
            return True
    return False
