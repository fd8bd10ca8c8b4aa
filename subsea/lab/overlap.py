"""Bodies of fishes that overlap."""

from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.rotation import rotate
from subsea.geometry.vector import dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.media.record import STATIONS, Record
from subsea.state import PREDATOR, PREY


class BeadBodies(NamedTuple):
    """Bodies as rows of ellipsoids, for the kernel."""

    snout: Array  # (T, n, 3) cm
    middle: Array  # (T, n, 3) cm
    tail: Array  # (T, n, 3) cm
    orientation: Array  # (T, n, 4)
    share: Array  # (n,) position of the middle along the body, 0 to 1
    sizes: Array  # (n, STATIONS, 2) half-width and half-height, cm


def overlaps(record: Record) -> Ints:
    """Overlap of each fish's body with another's (T, n): 0 none, 1 intended, 2 unintended.

    A body is a row of ellipsoids along its centre line from the snout over the middle to the tail,
    with the species' half-width and half-height there. Two of them overlap if their radii on the
    line between their centres add up to more than its length. This is exact for bodies side by
    side, but misses some that cross. Courting partners, and hunter and prey, touch intentionally.
    """
    outlines = np.stack([record.half_width, record.half_height], axis=2)[record.species]
    sizes = outlines * record.length[:, None, None]
    middle = record.snout_reach / record.length
    found = np.zeros(record.alive.shape, np.uint8)
    bodies = BeadBodies(
        record.snout, record.position, record.tail, record.orientation,
        np.clip(middle, 0.05, 0.95), sizes,
    )  # fmt: skip
    _overlap(bodies, record.alive, record.partner, record.kind, found)
    return found


@kernel
def _overlap(bodies: BeadBodies, alive: Bools, partner: Ints, kind: Ints, found: Ints) -> None:
    """Fill `found` (T, n)."""
    snout, middle, tail, orientation, share, sizes = bodies
    n = middle.shape[1]
    beads = np.empty((n, STATIONS, 3))
    low, high = np.empty((n, 3)), np.empty((n, 3))
    thick = np.empty(n)
    for i in range(n):
        thick[i] = sizes[i].max()
    for t in range(middle.shape[0]):
        for i in range(n):
            for k in range(STATIONS):
                s = k / (STATIONS - 1.0)
                for axis in range(3):
                    m = middle[t, i, axis]
                    if s < share[i]:
                        a = snout[t, i, axis]
                        beads[i, k, axis] = a + (m - a) * s / share[i]
                    else:
                        b = tail[t, i, axis]
                        beads[i, k, axis] = m + (b - m) * (s - share[i]) / (1.0 - share[i])
            for axis in range(3):
                low[i, axis] = beads[i, :, axis].min() - thick[i]
                high[i, axis] = beads[i, :, axis].max() + thick[i]
        order = np.argsort(low[:, 0], kind="mergesort")
        for a in range(n):
            i = order[a]
            if not alive[t, i]:
                continue
            for b in range(a + 1, n):
                j = order[b]
                if low[j, 0] > high[i, 0]:
                    break
                if (
                    not alive[t, j]
                    or low[j, 1] > high[i, 1] or low[i, 1] > high[j, 1]
                    or low[j, 2] > high[i, 2] or low[i, 2] > high[j, 2]
                ):  # fmt: skip
                    continue
                hunt = min(kind[i], kind[j]) == PREY and max(kind[i], kind[j]) == PREDATOR
                meant = partner[t, i] == j or partner[t, j] == i or hunt
                code = 1 if meant else 2
                if found[t, i] >= code and found[t, j] >= code:
                    continue
                if _touch(
                    beads[i], orientation[t, i], sizes[i], beads[j], orientation[t, j], sizes[j]
                ):
                    found[t, i] = max(found[t, i], code)
                    found[t, j] = max(found[t, j], code)


@kernel
def _touch(a: Array, a_turn: Array, a_size: Array, b: Array, b_turn: Array, b_size: Array) -> bool:
    """True if a bead of one body meets the line through the beads of the other."""
    return _meets(a, a_turn, a_size, b, b_turn, b_size) or _meets(
        b, b_turn, b_size, a, a_turn, a_size
    )


@kernel
def _meets(a: Array, a_turn: Array, a_size: Array, b: Array, b_turn: Array, b_size: Array) -> bool:
    most = a_size.max() + b_size.max()
    for k in range(STATIONS):
        here = vector(a[k])
        for m in range(STATIONS - 1):
            start = vector(b[m])
            way = minus(vector(b[m + 1]), start)
            long = max(dot(way, way), 1e-9)
            share = min(max(dot(minus(here, start), way) / long, 0.0), 1.0)
            gap = minus(plus(start, times(share, way)), here)
            distance = norm(gap)
            if distance > most:
                continue
            width = (1.0 - share) * b_size[m, 0] + share * b_size[m + 1, 0]
            height = (1.0 - share) * b_size[m, 1] + share * b_size[m + 1, 1]
            spacing = np.sqrt(long)
            reach = _radius(a_turn, a_size[k, 0], a_size[k, 1], spacing, gap, distance)
            reach += _radius(b_turn, width, height, spacing, gap, distance)
            if distance < reach:
                return True
    return False


@kernel
def _radius(
    turn: Array, width: float, height: float, spacing: float, gap: Any, distance: float
) -> float:
    """Radius of an ellipsoid in the direction of `gap`, cm."""
    if width < 1e-6 or height < 1e-6:
        return 0.0
    if distance < 1e-6:
        return min(width, height)
    x = dot(gap, rotate(turn, (1.0, 0.0, 0.0))) / distance / min(spacing, height)
    y = dot(gap, rotate(turn, (0.0, 1.0, 0.0))) / distance / height
    z = dot(gap, rotate(turn, (0.0, 0.0, 1.0))) / distance / width
    return 1.0 / np.sqrt(x * x + y * y + z * z)
