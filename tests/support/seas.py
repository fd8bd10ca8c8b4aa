"""Seas without inhabitants, for tests of what moves in them."""

import math

import numpy as np

from subsea.habitat.rocks import RockCells
from subsea.state import Sea, empty


def bare_sea(floor, radius=1300.0, half_width=1400.0, **solids):
    """A sea with these heights (m, m) of the seabed, or one height; `pillars` and `rocks`."""
    heights = np.full((2, 2), floor, np.float32) if np.isscalar(floor) else floor
    given = {"heights": heights, "floor": heights, "half_width": half_width, "radius": radius}
    return empty(Sea, given=given | solids, m=len(heights), k=0, p=0, c=0, s=0, q=0)


def all_rocks(rocks):
    """Cells that list all `rocks` (k, 7) everywhere."""
    turns = [(math.cos(yaw), math.sin(yaw)) for yaw in rocks[:, 6]]
    near = np.column_stack([rocks, np.reshape(turns, (len(rocks), 2))])
    return RockCells(0.0, 0.0, 0, 0, np.zeros(1, np.int64), near)
