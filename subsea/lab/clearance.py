"""Clearance of each fish from the bounds of the sea and from obstacles."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.height_field import height_at
from subsea.geometry.solids import from_pillar, from_rock
from subsea.kernels import kernel
from subsea.media.record import Record

BARRIERS = ("wall", "surface", "seabed", "pillar", "rock")


class Barriers(NamedTuple):
    """The bounds and obstacles of a sea, for the kernel."""

    heights: Array  # (m, m) cm, of the seabed
    half_width_cm: float  # of the seabed's square
    radius_cm: float
    pillars: Array  # (p, 4)
    rocks: Array  # (r, 7)


def clearances(record: Record) -> tuple[Array, Ints]:
    """Distance of each fish from the nearest barrier (T, n), cm, and its index in BARRIERS.

    The least over snout, middle and tail; negative where one of them is outside the sea or inside
    an obstacle. Distances from obstacles are those that the fishes perceive; from the seabed it is
    the height above it. Dead fishes are infinitely far away.
    """
    shape = record.alive.shape
    least = np.full(shape, np.inf, np.float32)
    which = np.zeros(shape, np.uint8)
    barriers = Barriers(
        record.heights, record.half_width_cm, record.radius_cm, record.pillars, record.rocks
    )
    for points in (record.snout, record.position, record.tail):
        _lower(points, record.alive, barriers, least, which)
    return least, which


@kernel
def _lower(points: Array, alive: Bools, barriers: Barriers, least: Array, which: Ints) -> None:
    """Lower `least` to the clearance of `points` (T, n, 3)."""
    for t in range(points.shape[0]):
        for i in range(points.shape[1]):
            if not alive[t, i]:
                continue
            x, y, z = float(points[t, i, 0]), float(points[t, i, 1]), float(points[t, i, 2])
            best, code = barriers.radius_cm - np.sqrt(x * x + y * y), 0
            if -z < best:
                best, code = -z, 1
            floor = z - height_at(barriers.heights, barriers.half_width_cm, x, y)
            if floor < best:
                best, code = floor, 2
            for k in range(len(barriers.pillars)):
                gap = from_pillar(barriers.pillars[k], (x, y, z))[1]
                if gap < best:
                    best, code = gap, 3
            for k in range(len(barriers.rocks)):
                gap = from_rock(barriers.rocks[k], (x, y, z))[1]
                if gap < best:
                    best, code = gap, 4
            if best < least[t, i]:
                least[t, i], which[t, i] = best, code
