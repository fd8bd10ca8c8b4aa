"""How far a place is from what stands on the seabed: pillars and rocks."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.vector import Vector, vector

Array = NDArray[np.floating[Any]]


@njit(cache=True, error_model="numpy")
def from_pillar(pillar: Array, p: Vector) -> tuple[Vector, float]:
    """The way off a pillar at p, and how far p is from it (cm, negative inside).

    A row of `Sea.pillars`. The way is a unit vector, outward from the axis, or up over its top.
    """
    dx, dy = p[0] - pillar[0], p[1] - pillar[1]
    axis = max(np.sqrt(dx * dx + dy * dy), 1e-9)
    aside, above = axis - pillar[2], p[2] - pillar[3]
    if aside > 0.0 and above > 0.0:
        corner = np.sqrt(aside * aside + above * above)
        share = aside / (corner * axis)
        return (dx * share, dy * share, above / corner), corner
    if above > aside:
        return (0.0, 0.0, 1.0), above
    return (dx / axis, dy / axis, 0.0), aside


@njit(cache=True, error_model="numpy")
def from_rock(rock: Array, p: Vector) -> tuple[Vector, float]:
    """The way off a rock at p, and about how far p is from it (cm, negative inside).

    A row of `Sea.rocks`. The distance is exact on the surface and to first order near it.
    """
    c, s = np.cos(rock[6]), np.sin(rock[6])
    dx, dy, dz = p[0] - rock[0], p[1] - rock[1], p[2] - rock[2]
    x, y, z = (c * dx + s * dy) / rock[3], (c * dy - s * dx) / rock[4], dz / rock[5]
    scaled = np.sqrt(x * x + y * y + z * z)
    gx, gy, gz = x / rock[3], y / rock[4], z / rock[5]
    slope = np.sqrt(gx * gx + gy * gy + gz * gz)
    if slope < 1e-9:  # its very middle
        return (0.0, 0.0, 1.0), -min(rock[3], rock[4], rock[5])
    way = ((c * gx - s * gy) / slope, (s * gx + c * gy) / slope, gz / slope)
    return way, scaled * (scaled - 1.0) / slope


@njit(cache=True, error_model="numpy")
def clearance(pillars: Array, rocks: Array, p: Vector) -> float:
    """How far p is from the nearest solid (cm, negative inside); infinite if there is none."""
    nearest = np.inf
    for k in range(len(pillars)):
        nearest = min(nearest, from_pillar(pillars[k], p)[1])
    for k in range(len(rocks)):
        nearest = min(nearest, from_rock(rocks[k], p)[1])
    return nearest


@njit(cache=True, error_model="numpy")
def is_free(pillars: Array, rocks: Array, p: Vector) -> bool:
    """Whether p lies in no solid; cheaper than `clearance`."""
    for k in range(len(pillars)):
        x, y, radius, top = pillars[k]
        if p[2] < top and (p[0] - x) ** 2 + (p[1] - y) ** 2 < radius * radius:
            return False
    for k in range(len(rocks)):
        reach = max(rocks[k, 3], rocks[k, 4])
        near = abs(p[0] - rocks[k, 0]) < reach and abs(p[1] - rocks[k, 1]) < reach
        if near and from_rock(rocks[k], p)[1] < 0.0:
            return False
    return True


@njit(cache=True, error_model="numpy")
def clearances(pillars: Array, rocks: Array, places: Array) -> Array:
    """How far each of the places (n, 3) is from the nearest solid (n,), cm."""
    far = np.empty(len(places))
    for k in range(len(places)):
        far[k] = clearance(pillars, rocks, vector(places[k]))
    return far
