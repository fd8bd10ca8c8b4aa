"""Distances of places from pillars and rocks, and the way out of these."""

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.height_field import height_at
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import Vector, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import Sea

MAX_STEPS = 12  # most steps out of overlapping solids


@kernel
def clearance(pillars: Array, rocks: Array, p: Vector) -> float:
    """Distance of p from the nearest solid (cm, negative inside); infinite without solids."""
    nearest = np.inf
    for k in range(len(pillars)):
        nearest = min(nearest, from_pillar(pillars[k], p)[1])
    for k in range(len(rocks)):
        nearest = min(nearest, from_rock(rocks[k], p)[1])
    return nearest


@kernel
def clearances(pillars: Array, rocks: Array, places: Array) -> Array:
    """Distances (n,) of places (n, 3) from the nearest solid, cm."""
    far = np.empty(len(places))
    for k in range(len(places)):
        far[k] = clearance(pillars, rocks, vector(places[k]))
    return far


@kernel
def is_free(pillars: Array, rocks: Array, p: Vector) -> bool:
    """True if p lies in no solid; cheaper than `clearance`."""
    for k in range(len(pillars)):
        x, y, radius, top = pillars[k]
        if p[2] < top and (p[0] - x) ** 2 + (p[1] - y) ** 2 < radius * radius:
            return False
    for k in range(len(rocks)):
        reach = max(rocks[k, 3], rocks[k, 4])
        near = abs(p[0] - rocks[k, 0]) < reach and abs(p[1] - rocks[k, 1]) < reach
        near = near and abs(p[2] - rocks[k, 2]) < rocks[k, 5]
        if near and from_rock(rocks[k], p)[1] < 0.0:
            return False
    return True


@kernel
def out_of_solids(sea: Sea, p: Vector, room: float, above: float, below: float) -> Vector:
    """A place near p that keeps `room` cm off every solid.

    It is at least `above` cm over the floor and `below` cm under the surface. Returns the last
    place tried if solids stand too close for that.
    """
    for _ in range(MAX_STEPS):
        moved = False
        for k in range(len(sea.pillars)):
            x, y, radius, top = sea.pillars[k]
            if top + room > -below:  # no way over it
                top = np.inf
            way, gap = from_pillar((x, y, radius, top), p)
            if gap < room:
                p, moved = plus(p, times(room - gap + 0.1, way)), True
        for k in range(len(sea.rocks)):
            way, gap = from_rock(sea.rocks[k], p)
            if gap < room:
                ground = height_at(sea.heights, sea.half_width, p[0], p[1])
                roof = sea.rocks[k, 2] - sea.rocks[k, 5]
                if way[2] < 0.0 and roof < ground + above + room:  # aside, not into the ground
                    level = (way[0], way[1], 0.0)
                    way = times(1.0 / max(norm(level), 1e-3), level)
                p, moved = plus(p, times(room - gap + 0.1, way)), True
        floor = height_at(sea.floor, sea.half_width, p[0], p[1])
        height = min(max(p[2], floor + above), -below)
        if height != p[2]:  # which may have brought it to a solid
            p, moved = (p[0], p[1], height), True
        if not moved:
            break
    return p
