"""Possible mates in sight (Tu §7.9.3)."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.perception.grid import Grid, insert, near_slots
from subsea.perception.vision import eye_of, sees_fish, sight
from subsea.state import LIBIDO, LOOPING, NOBODY, PACIFIST, Fishes, Minds, Nature, Sea

CELL_CM = 100.0
ODD = 2.0  # largest ratio of lengths between mates of different species
TEMPTING_CM = 40.0  # range of a mate for a fish without libido (Tu §7.4)
STRANGE_CM = 1e6  # added to the distance of another species


@kernel
def see_mates(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, grid: Grid, nature: Nature
) -> None:
    """Set the possible mates of the fishes `who`, from the pacifists in `grid`.

    Same species come first, then the nearest. A fish with too little libido to court looks only as
    far as a mate can tempt it. A mate is of the other sex, not shunned and not circling with
    another; one of another species must be of similar size. A female does not consider a male that
    courts another: she chooses another one (Tu §7.9.3). Two fishes betrothed by a direction
    know of each other anywhere and have no other mates.
    """
    longest = 0.0
    for j in grid.member:
        longest = max(longest, float(fishes.length[j]))
    cost = np.empty(minds.mates.shape[1])
    slots = np.empty(len(grid.member), np.int64)
    for i in who:
        found = minds.mates[i]
        found[:] = -1
        cost[:] = np.inf
        if minds.betrothed[i] >= 0:
            j = minds.betrothed[i]
            if minds.shunned[i] != j:
                there = vector(fishes.position[j])
                insert(found, cost, j, norm(minus(there, eye_of(fishes, i))))
        elif minds.kind[i] == PACIFIST:
            eye = eye_of(fishes, i)
            farthest = sight(longest, nature)
            if minds.mental[i, LIBIDO] <= nature.keen:
                farthest = min(farthest, TEMPTING_CM)
            inner, outer = -1.0, min(grid.cell, farthest)
            while True:
                for k in range(near_slots(grid, eye, outer, slots)):
                    j = grid.member[slots[k]]
                    price = norm(minus(vector(grid.place[slots[k]]), eye))
                    if not inner < price <= outer or minds.male[i] == minds.male[j]:
                        continue
                    taken = minds.courtship[j] > LOOPING and minds.partner[j] != i
                    species = fishes.species
                    odd = not 1.0 / ODD < fishes.length[i] / fishes.length[j] < ODD
                    taken |= minds.betrothed[j] >= 0
                    courts = minds.partner[j] != NOBODY and minds.partner[j] != i
                    taken |= courts and not minds.male[i]
                    if minds.shunned[i] == j or taken or (odd and species[i] != species[j]):
                        continue
                    if species[i] != species[j]:
                        price += STRANGE_CM
                    if price <= cost[-1] and sees_fish(fishes, i, j, sea, nature):
                        insert(found, cost, j, price)
                if cost[-1] <= outer or outer >= farthest:
                    break
                inner, outer = outer, min(2.0 * outer, farthest)
        minds.mate[i] = found[0]
        minds.mate_distance[i] = cost[0] - STRANGE_CM if cost[0] >= STRANGE_CM else cost[0]
