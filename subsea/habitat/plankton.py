"""Plankton: floating points that the current carries (Tu §8.2)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.heightfield import height_at
from subsea.kinematics.keyed import uniform

Array = NDArray[np.floating[Any]]

WANDER_CM_S = 4.0  # size of a speck's own random motion
HOLD_TICKS = 45  # a speck keeps its random direction this long
CLEARANCE_CM = 12.0  # from the seabed and from the surface


def scatter(
    rng: np.random.Generator, number: int, radius: float, heights: Array, half_width: float
) -> Array:
    """Places (p, 3) float32, cm: even over the cylinder's area and over the water's height."""
    angle = rng.uniform(0, 2 * np.pi, number)
    distance = radius * np.sqrt(rng.uniform(0, 1, number))
    share = rng.uniform(0, 1, number)
    places = np.zeros((number, 3), np.float32)
    for k in range(number):
        x, y = distance[k] * np.cos(angle[k]), distance[k] * np.sin(angle[k])
        floor = height_at(heights, half_width, x, y) + CLEARANCE_CM
        places[k] = x, y, floor + share[k] * (-CLEARANCE_CM - floor)
    return places


@njit(cache=True)
def drift(
    plankton: Array,
    flow: Array,
    radius: float,
    heights: Array,
    half_width: float,
    seed: int,
    tick: int,
    dt: float,
) -> None:
    """Move every speck by one tick; one that leaves the cylinder comes in on the other side."""
    for k in range(len(plankton)):
        epoch = (tick + k) // HOLD_TICKS
        for axis in range(3):
            own = WANDER_CM_S * (2.0 * uniform(seed, k, epoch, 100 + axis) - 1.0)
            plankton[k, axis] += np.float32((flow[axis] + own) * dt)
        x, y = plankton[k, 0], plankton[k, 1]
        if x * x + y * y > radius * radius:
            shrink = np.float32(-0.98)
            plankton[k, 0] = shrink * x
            plankton[k, 1] = shrink * y
        floor = height_at(heights, half_width, plankton[k, 0], plankton[k, 1]) + CLEARANCE_CM
        plankton[k, 2] = np.float32(min(max(plankton[k, 2], floor), -CLEARANCE_CM))
