"""Nearest companions, as felt by the lateral line in all directions (Tu §6.3)."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.vector import vector
from subsea.kernels import kernel
from subsea.perception.grid import Grid, farthest, make_grid, nearest
from subsea.state import Fishes, Minds

REACH_CM = 110.0  # range of companions ...
SCHOOL_CM = 300.0  # ... and of fishes that school, which also see them
CELL_CM = 60.0  # large enough that few cells are empty


def grid_of(fishes: Fishes, kind: int) -> Grid:
    """The living fishes of a species."""
    fellows = np.flatnonzero(fishes.alive & (fishes.species == kind))
    return make_grid(fishes.position, fellows, CELL_CM)


@kernel
def find_neighbours(who: Ints, fishes: Fishes, minds: Minds, grid: Grid) -> None:
    """Set `minds.neighbour` of the fishes `who`: the nearest within reach in the grid.

    The grid has all fishes of their species. Equal distances are ordered by index, so the result
    does not depend on the order of `who`.
    """
    gaps = np.empty(minds.neighbour.shape[1])
    for i in who:
        here = vector(fishes.position[i])
        reach = SCHOOL_CM if minds.schools[i] else REACH_CM
        guess = farthest(fishes.position, here, minds.neighbour[i])
        nearest(grid, here, reach, i, minds.neighbour[i], gaps, guess)
