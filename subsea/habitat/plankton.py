"""Plankton: floating points that the current carries (Tu §8.2)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.heightfield import height_at
from subsea.kinematics.keyed import uniform
from subsea.state import Clock, Sea

Array = NDArray[np.floating[Any]]

WANDER_CM_S = 4.0  # size of a speck's own random motion
HOLD_TICKS = 45  # a speck keeps its random direction this long
CLEARANCE_CM = 12.0  # from the seabed and from the surface
RETURN_PURPOSE = 110  # key of the random numbers


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


@njit(cache=True, error_model="numpy")
def drift(sea: Sea, flow: Array, clock: Clock) -> None:
    """Move every speck by one tick; one that leaves the cylinder comes in on the other side.

    A speck that was eaten comes in again after its absence, where the current enters.
    """
    for k in range(len(sea.plankton)):
        speck = sea.plankton[k]
        if sea.absent[k] > 0.0:
            sea.absent[k] = max(sea.absent[k] - clock.dt, 0.0)
            if sea.absent[k] == 0.0:
                angle = np.arctan2(-flow[1], -flow[0])
                angle += 2.0 * uniform(clock.seed, k, clock.tick, RETURN_PURPOSE) - 1.0
                speck[0] = 0.97 * sea.radius * np.cos(angle)
                speck[1] = 0.97 * sea.radius * np.sin(angle)
                share = uniform(clock.seed, k, clock.tick, RETURN_PURPOSE + 1)
                floor = height_at(sea.heights, sea.half_width, speck[0], speck[1]) + CLEARANCE_CM
                speck[2] = floor + share * (-CLEARANCE_CM - floor)
            continue
        epoch = (clock.tick + k) // HOLD_TICKS
        for axis in range(3):
            own = WANDER_CM_S * (2.0 * uniform(clock.seed, k, epoch, 100 + axis) - 1.0)
            speck[axis] += np.float32((flow[axis] + own) * clock.dt)
        if speck[0] * speck[0] + speck[1] * speck[1] > sea.radius * sea.radius:
            shrink = np.float32(-0.98)
            speck[0] *= shrink
            speck[1] *= shrink
        floor = height_at(sea.heights, sea.half_width, speck[0], speck[1]) + CLEARANCE_CM
        speck[2] = np.float32(min(max(speck[2], floor), -CLEARANCE_CM))
