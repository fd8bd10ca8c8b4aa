"""Seas without inhabitants, for tests of what moves in them."""

import numpy as np

from subsea.habitat.rocks import LISTED, RockCells, rock_cells
from subsea.state import Sea, empty


def bare_sea(floor, radius=1300.0, half_width=1400.0, **solids):
    """A sea with these heights (m, m) of the seabed, or one height; `pillars` and `rocks`."""
    heights = np.full((2, 2), floor, np.float32) if np.isscalar(floor) else floor
    given = {"heights": heights, "floor": heights, "half_width": half_width, "radius": radius}
    return empty(Sea, given=given | solids, m=len(heights), k=0, p=0, c=0, s=0, q=0)


def all_rocks(rocks):
    """Cells that list all `rocks` (k, 7) everywhere."""
    one_by_one = [rock_cells(rocks[k : k + 1], 0.0).near for k in range(len(rocks))]
    near = np.concatenate([np.zeros((0, LISTED)), *one_by_one])
    return RockCells(0.0, 0.0, 0, 0, np.zeros(1, np.int64), near)
