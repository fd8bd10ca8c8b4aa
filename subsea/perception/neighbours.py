"""Nearest companions, as felt by the lateral line in all directions (Tu §6.3)."""

import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel
from subsea.geometry.vector import vector
from subsea.perception.grid import Grid, make_grid, nearest
from subsea.state import Fishes, Minds

REACH_CM = 110.0  # range of companions
CELL_CM = 60.0  # large enough that few cells are empty


def find_neighbours(who: Ints, fishes: Fishes, minds: Minds, reach: float) -> None:
    """Set `minds.neighbour` of the fishes `who`: the nearest of their species within `reach` cm.

    Equal distances are ordered by index, so the result does not depend on the order of `who`.
    """
    kinds = fishes.species[who]
    for kind in np.unique(kinds):
        fellows = np.flatnonzero(fishes.alive & (fishes.species == kind))
        grid = make_grid(fishes.position, fellows, CELL_CM)
        _find(who[kinds == kind], fishes.position, minds.neighbour, grid, reach)


@kernel
def _find(who: Ints, position: Array, neighbour: Ints, grid: Grid, reach: float) -> None:
    gaps, slots = np.empty(neighbour.shape[1]), np.empty(len(grid.member), np.int64)
    for i in who:
        nearest(grid, vector(position[i]), reach, i, neighbour[i], gaps, slots)
