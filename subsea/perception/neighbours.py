"""Who swims beside a fish: what its lateral line feels, in all directions (Tu §6.3)."""

import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel
from subsea.geometry.vector import vector
from subsea.perception.grid import Grid, make_grid, nearest
from subsea.state import Fishes, Minds

REACH_CM = 110.0  # how far a fish looks for companions
CELL_CM = 60.0  # side of a cell: large enough that few are empty


def find_neighbours(who: Ints, fishes: Fishes, minds: Minds, reach: float) -> None:
    """Enter into `minds.neighbour` of the fishes `who` the nearest living ones of the same species.

    They are within `reach` cm. Equal distances are told apart by index, so the answer does not
    depend on order.
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
