"""Places in a box with periodic sides: what leaves on one side comes in on the other.

The sides along x and y are periodic, surface and seabed are not. Two places are as far apart as
their nearest images are (the minimum image convention of molecular dynamics). A period (2,), cm, is
the length of the box along x and along y, or 0 without a box.
"""

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.vector import Vector
from subsea.kernels import kernel


@kernel
def nearest_image(p: Vector, here: Vector, period: Array) -> Vector:
    """Return the image of the place p that is nearest to `here`: p itself without a box.

    Numbers keep their precision, as compiled code distinguishes vectors by it.
    """
    if period[0] <= 0.0:
        return p
    x, y = p[0], p[1]
    while x - here[0] > 0.5 * period[0]:
        x -= period[0]
    while here[0] - x > 0.5 * period[0]:
        x += period[0]
    while y - here[1] > 0.5 * period[1]:
        y -= period[1]
    while here[1] - y > 0.5 * period[1]:
        y += period[1]
    return x, y, p[2]


def laps_of(places: Array, period: Array) -> Array:
    """Count the periods (…, 2) by which places (…, 2 or 3) lie beyond a box about the origin."""
    return np.floor(np.asarray(places[..., :2], np.float64) / period + 0.5)


def shortest(ways: Array, period: Array) -> Array:
    """Replace differences of places (…, 3) by those of their nearest images.

    Without a box they stay as they are.
    """
    if not period[0]:
        return ways
    near = np.array(ways)
    near[..., :2] -= laps_of(near, period) * period
    return near


def in_box(places: Array, origins: Array, period: Array) -> Array:
    """Shift places (…, 3) by the periods that bring `origins` (…, 3) into the box."""
    if not period[0]:
        return places
    inside = np.array(places)
    inside[..., :2] -= laps_of(origins, period) * period
    return inside


def gathered(places: Array, period: Array) -> Array:
    """Replace places (m, 3) by their images around the middle of all.

    The middle is the circular mean along x and y. Without a box the places stay.
    """
    if not period[0] or not len(places):
        return places
    middle = np.zeros(3)
    middle[:2] = circular_mean(places, period)
    return middle + shortest(places - middle, period)


def circular_mean(places: Array, period: Array) -> Array:
    """Average places (m, 3) on the circles that x and y are in a box: the middle (2,), cm."""
    turns = 2.0 * np.pi * np.asarray(places[:, :2], np.float64) / period
    angle = np.arctan2(np.sin(turns).mean(axis=0), np.cos(turns).mean(axis=0))
    return np.asarray(angle / (2.0 * np.pi) * period)
