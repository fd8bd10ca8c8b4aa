"""Nearest companions, as felt by the lateral line in all directions (Tu §6.3)."""

import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel
from subsea.geometry.vector import vector
from subsea.perception.grid import Grid, make_grid, nearest
from subsea.state import Fishes, Minds

REACH_CM = 110.0  # range of companions ...
SCHOOL_CM = 300.0  # ... and of fishes that school, which also see them
CELL_CM = 60.0  # large enough that few cells are empty


def find_neighbours(who: Ints, fishes: Fishes, minds: Minds) -> None:
    """Set `minds.neighbour` of the fishes `who`: the nearest of their species within reach.

    Equal distances are ordered by index, so the result does not depend on the order of `who`.
    """
    kinds = fishes.species[who]
    for kind in np.unique(kinds):
        fellows = np.flatnonzero(fishes.alive & (fishes.species == kind))
        grid = make_grid(fishes.position, fellows, CELL_CM)
        _find(who[kinds == kind], fishes.position, minds, grid)


@kernel
def _find(who: Ints, position: Array, minds: Minds, grid: Grid) -> None:
    gaps, slots = np.empty(minds.neighbour.shape[1]), np.empty(len(grid.member), np.int64)
    for i in who:
        reach = SCHOOL_CM if minds.schools[i] else REACH_CM
        nearest(grid, vector(position[i]), reach, i, minds.neighbour[i], gaps, slots)
