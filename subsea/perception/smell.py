"""Smell what the water carries: bait, blood and alarm substance (`habitat/odour.py`)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.vector import Vector, norm, store, times
from subsea.kernels import kernel
from subsea.perception.vision import eye_of
from subsea.state import BAIT_ODOUR, BLOOD, Fishes, Minds, Odour


@kernel
def smell(who: Ints, fishes: Fishes, minds: Minds, odour: Odour) -> None:
    """Set `minds.scent` of the fishes `who`, and the way to more food of those that scavenge."""
    for i in who:
        nostrils = eye_of(fishes, i)
        for channel in range(len(odour.total)):
            minds.scent[i, channel] = 0.0
            if odour.total[channel] > 0.0:
                minds.scent[i, channel] = strength(odour, odour.amount[channel], nostrils)
        if minds.scavenges[i]:
            x, y, z = 0.0, 0.0, 0.0
            if minds.scent[i, BAIT_ODOUR] > 0.0:
                x, y, z = slope(odour, odour.amount[BAIT_ODOUR], nostrils)
            if minds.scent[i, BLOOD] > minds.scent[i, BAIT_ODOUR]:
                x, y, z = slope(odour, odour.amount[BLOOD], nostrils)
            steep = norm((x, y, z))
            store(minds.richer[i], times(1.0 / steep if steep > 0.0 else 0.0, (x, y, z)))


@kernel
def strength(odour: Odour, amount: Array, p: Vector) -> float:
    """Interpolate an odour (z, y, x) at p between the middles of the cells of water around it."""
    x = (p[0] - odour.corner[0]) / odour.cell_cm - 0.5
    y = (p[1] - odour.corner[1]) / odour.cell_cm - 0.5
    z = (p[2] - odour.corner[2]) / odour.cell_cm - 0.5
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    nz, ny, nx = amount.shape
    total, weights = 0.0, 0.0
    for c in range(max(k, 0), min(k + 2, nz)):
        for b in range(max(j, 0), min(j + 2, ny)):
            for a in range(max(i, 0), min(i + 2, nx)):
                if odour.water[c, b, a]:
                    weight = (1.0 - abs(x - a)) * (1.0 - abs(y - b)) * (1.0 - abs(z - c))
                    total += weight * amount[c, b, a]
                    weights += weight
    return total / weights if weights > 1e-6 else 0.0


@kernel
def slope(odour: Odour, amount: Array, p: Vector) -> Vector:
    """Measure how an odour rises at p along x, y and z, from half a cell to either side."""
    half = 0.5 * odour.cell_cm
    east = strength(odour, amount, (p[0] + half, p[1], p[2]))
    west = strength(odour, amount, (p[0] - half, p[1], p[2]))
    north = strength(odour, amount, (p[0], p[1] + half, p[2]))
    south = strength(odour, amount, (p[0], p[1] - half, p[2]))
    above = strength(odour, amount, (p[0], p[1], p[2] + half))
    below = strength(odour, amount, (p[0], p[1], p[2] - half))
    return east - west, north - south, above - below
