"""A tree of boxes around all fishes and their velocities, for the search of fishes that may meet.

A bounding volume hierarchy (Kay and Kajiya, SIGGRAPH 1986), built in each tick by tiling the sea
into slabs, bars and blocks of eight fishes (Leutenegger et al., ICDE 1997, sort-tile-recursive). A
node has eight children, whose boxes are tested at once (`kernels/lanes.py`). What a search finds
does not depend on the shape of the tree.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from subsea.base.arrays import Array, Ints
from subsea.geometry.vector import Vector, store
from subsea.kernels import kernel
from subsea.kernels.lanes import LANES, VECTOR, as_lanes, uncounted
from subsea.perception.grid import images_of
from subsea.perception.vision import along_body
from subsea.state import NOBODY, Fishes

WIDE = LANES  # children of a node, and fishes of a block
BINS = (1024, 256, 128)  # of the sorts along x, y and z
NOWHERE = 1e15  # cm: the place of a child that a node lacks, out of the reach of any search
STILL = 1e-100  # cm²/s²: less than the square of any speed of one fish relative to another
ROUNDING = 1.0 + 1e-9  # on the reach of a search, so that it misses nobody
# Rows of `Crowd.fish` and of `Crowd.box`: places, velocities and radius.
X, Y, Z, U, V, W, RADIUS = range(7)
LOW, HIGH, SLOWEST, FASTEST, LARGEST = 0, 3, 6, 9, 12


class Crowd(NamedTuple):
    """m places of living fishes in b blocks, and the boxes of all nodes above them."""

    member: Ints  # (8 b,) int64: the fish in each slot of the blocks, or NOBODY
    fish: Array  # (b, 7, 8) rows X to RADIUS: middle, cm, velocity, cm/s, radius about it, cm
    box: Array  # (nodes, 13, 8): bounds of the eight children, rows LOW to LARGEST, cm and cm/s
    first: Ints  # (levels + 1,) first node of each level; nodes of level 0 have blocks as children


@kernel
def crowd_of(fishes: Fishes) -> Crowd:
    """Sort the middles of all living fishes, in a box with their images, into a tree."""
    n = len(fishes.length)
    middles, living, count = np.empty((n, 3)), np.empty(n, np.int64), 0
    for i in range(n):
        if fishes.alive[i]:
            store(middles[i], along_body(fishes, i, 0.5))
            living[count] = i
            count += 1
    place, chosen = images_of(middles, living[:count], fishes.period)
    order = _tiled(place)
    crowd = _empty_crowd(len(place))
    for k in range(len(order)):
        block, lane, i = k // WIDE, k % WIDE, chosen[order[k]]
        crowd.member[k] = i
        for axis in range(3):
            crowd.fish[block, X + axis, lane] = place[order[k], axis]
            crowd.fish[block, U + axis, lane] = fishes.velocity[i, axis]
        crowd.fish[block, RADIUS, lane] = radius_of(fishes, i)
    _bound(crowd)
    return crowd


@kernel
def radius_of(fishes: Fishes, i: int) -> float:
    """Farthest distance of any part of fish i from its middle, cm."""
    girth = float(fishes.girth[i, 0]) + float(fishes.girth[i, 1])
    return 0.5 * (float(fishes.length[i]) + girth)


@kernel
def _tiled(place: Array) -> Ints:
    """Order places (m, 3) by slabs along x, by bars along y within a slab, and by z within a bar.

    With as many bars in a slab as slabs, and as many blocks in a bar.
    """
    m = len(place)
    side = math.ceil((max(m, 1) / WIDE) ** (1.0 / 3.0))
    slab, bar = side * side * WIDE, side * WIDE
    order, spare = np.arange(m), (np.empty(m, np.int64), np.empty(BINS[0] + 1, np.int64))
    _sort(place, 0, order, spare, BINS[0])
    for a in range(0, m, slab):
        _sort(place, 1, order[a : a + slab], spare, BINS[1])
        for b in range(a, min(a + slab, m), bar):
            _sort(place, 2, order[b : min(b + bar, a + slab)], spare, BINS[2])
    return order


@kernel
def _sort(place: Array, axis: int, order: Ints, spare: tuple[Ints, Ints], bins: int) -> None:
    """Sort `order` (k,), indices of `place`, by equal bins along an axis, in place.

    Members of a bin keep their order. `spare` is memory for k indices and `bins` + 1 counts.
    """
    before, start = spare
    low, high = np.inf, -np.inf
    for k in range(len(order)):
        x = place[order[k], axis]
        low, high = min(low, x), max(high, x)
    per_cm = (bins - 0.5) / max(high - low, 1e-3)
    start[: bins + 1] = 0
    for k in range(len(order)):
        before[k] = order[k]
        start[int((place[order[k], axis] - low) * per_cm) + 1] += 1
    for b in range(bins):
        start[b + 1] += start[b]
    for k in range(len(order)):
        b = int((place[before[k], axis] - low) * per_cm)
        order[start[b]] = before[k]
        start[b] += 1


@kernel
def _empty_crowd(m: int) -> Crowd:
    """Make a tree of m places whose nodes have no children yet."""
    blocks = (m + WIDE - 1) // WIDE
    first, levels, count = np.zeros(24, np.int64), 0, blocks
    while count > 1 or levels == 0:
        count = (count + WIDE - 1) // WIDE
        first[levels + 1] = first[levels] + max(count, 1)
        levels += 1
    crowd = Crowd(
        np.full(blocks * WIDE, np.int64(NOBODY)),
        np.zeros((blocks, RADIUS + 1, WIDE)),
        np.zeros((first[levels], LARGEST + 1, WIDE)),
        first[: levels + 1],
    )
    crowd.fish[:, X : Z + 1] = NOWHERE
    crowd.box[:, LOW:SLOWEST] = NOWHERE
    return crowd


@kernel
def _bound(crowd: Crowd) -> None:
    """Write the boxes of all nodes, from the blocks up."""
    slots = crowd.member
    for block in range(len(crowd.fish)):
        count, box, lane = 0, crowd.box[block // WIDE], block % WIDE
        while count < WIDE and slots[block * WIDE + count] != NOBODY:
            count += 1
        for row in range(RADIUS):
            low = high = crowd.fish[block, row, 0]
            for k in range(1, count):
                low = min(low, crowd.fish[block, row, k])
                high = max(high, crowd.fish[block, row, k])
            at = LOW + row if row < U else SLOWEST + row - U
            box[at, lane], box[at + HIGH, lane] = low, high
        for k in range(count):
            box[LARGEST, lane] = max(box[LARGEST, lane], crowd.fish[block, RADIUS, k])
    below = len(crowd.fish)
    for level in range(1, len(crowd.first) - 1):
        nodes = (below + WIDE - 1) // WIDE
        for node in range(nodes):
            child = crowd.box[crowd.first[level - 1] + node]
            box, lane = crowd.box[crowd.first[level] + node // WIDE], node % WIDE
            count = min(WIDE, below - node * WIDE)
            for row in range(LARGEST + 1):
                bound = child[row, 0]
                least = row < HIGH or SLOWEST <= row < FASTEST
                for k in range(1, count):
                    bound = min(bound, child[row, k]) if least else max(bound, child[row, k])
                box[row, lane] = bound
        below = nodes


@kernel
def room_for(crowd: Crowd) -> Ints:
    """Make the memory (2, 8 b + 8) for the slots that searches in a crowd find."""
    return np.empty((2, len(crowd.member) + WIDE), np.int64)


class Path(NamedTuple):
    """The way of a body for a while."""

    here: Vector  # cm
    velocity: Vector  # cm/s
    radius: float  # cm, of the body and the room that it keeps
    lasts: float  # s


@kernel
def find_meetings(crowd: Crowd, path: Path, slots: Ints) -> tuple[int, int]:
    """Find the fishes whose spheres come within the radius of a path while it lasts.

    Fishes keep their velocities. Writes slots of the crowd to `slots`, memory from `room_for`.
    Returns the row of them and their number. The fish itself is among them.
    """
    if len(crowd.member) == 0:
        return 0, 0
    fish, box = uncounted(as_lanes(crowd.fish)), uncounted(as_lanes(crowd.box))
    x, y, z = path.here
    u, v, w = path.velocity
    radius, lasts = ROUNDING * path.radius, path.lasts
    now, count = 0, 1
    slots[0, 0] = 0
    # Level by level: a processor tests several nodes at once if none waits for the one before.
    for level in range(len(crowd.first) - 2, -1, -1):
        reached = 0
        for n in range(count):
            node = slots[now, n]
            b = crowd.first[level] + node
            east = max(max(box[b, LOW] - x, x - box[b, HIGH]), 0.0)
            north = max(max(box[b, LOW + 1] - y, y - box[b, HIGH + 1]), 0.0)
            up = max(max(box[b, LOW + 2] - z, z - box[b, HIGH + 2]), 0.0)
            # The greatest speed of any child relative to the path.
            p = max(u - box[b, SLOWEST], box[b, FASTEST] - u)
            q = max(v - box[b, SLOWEST + 1], box[b, FASTEST + 1] - v)
            r = max(w - box[b, SLOWEST + 2], box[b, FASTEST + 2] - w)
            far = radius + box[b, LARGEST] + lasts * math.sqrt(p * p + q * q + r * r)
            near = not_negative(far * far - (east * east + north * north + up * up))
            for k in range(WIDE):
                slots[1 - now, reached] = node * WIDE + k
                reached += (near >> k) & 1
        now, count = 1 - now, reached
    met = 0
    for n in range(count):
        b = slots[now, n]
        east, north, up = fish[b, X] - x, fish[b, Y] - y, fish[b, Z] - z
        p, q, r = fish[b, U] - u, fish[b, V] - v, fish[b, W] - w
        # Closest approach of the middles, within which the radii must reach.
        time = max(-(east * p + north * q + up * r), 0.0) / max(p * p + q * q + r * r, STILL)
        time = min(time, lasts)
        east, north, up = east + time * p, north + time * q, up + time * r
        far = radius + fish[b, RADIUS]
        near = not_negative(far * far - (east * east + north * north + up * up))
        for k in range(WIDE):
            slots[1 - now, met] = b * WIDE + k
            met += (near >> k) & 1
    return 1 - now, met


@kernel
def place_of(crowd: Crowd, slot: int) -> Vector:
    """The place of the fish in a slot, cm; in a box that of an image."""
    block, lane = slot // WIDE, slot % WIDE
    return crowd.fish[block, X, lane], crowd.fish[block, Y, lane], crowd.fish[block, Z, lane]


@intrinsic
def not_negative(context: Any, value: Any) -> Any:
    """The lanes that are not negative, as bits of a number: bit k for lane k."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        none = ir.Constant(VECTOR, [0.0] * LANES)
        bits = builder.bitcast(builder.fcmp_ordered(">=", values[0], none), ir.IntType(LANES))
        return builder.zext(bits, ir.IntType(64))

    return types.int64(value), code
