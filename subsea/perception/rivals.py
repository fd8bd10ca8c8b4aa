"""Notice other predators nearby, and the prey that they claim."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.perception.grid import Grid, near_slots
from subsea.state import EAT, NOBODY, PREDATOR, RUSHING, Fishes, Minds

RIVAL_BL = 2.5  # distance within which another predator is a rival, mean lengths of both
CLAIM_CM = 1000.0  # distance within which its claim to a prey counts


@kernel
def perceive_rivals(who: Ints, fishes: Fishes, minds: Minds, grid: Grid) -> None:
    """Set the rivals of the predators among the fishes `who`, and the prey that they concede.

    `grid` has all predators. A prey that two of them target belongs to the one that rushes at it,
    else to the larger one.
    """
    slots = np.empty(len(grid.member), np.int64)
    for i in who:
        if minds.kind[i] != PREDATOR:
            continue
        minds.rival[i] = minds.conceded[i] = NOBODY
        here, least, nearest = vector(fishes.position[i]), np.inf, np.inf
        for k in range(near_slots(grid, here, CLAIM_CM, slots)):
            j = grid.member[slots[k]]
            if j == i or not fishes.alive[j]:
                continue
            gap = norm(minus(vector(grid.place[slots[k]]), here))
            reach = RIVAL_BL * 0.5 * (fishes.length[i] + fishes.length[j])
            if gap < reach and gap < least:
                minds.rival[i], least = j, gap
            hunts = minds.intention[j] == EAT and minds.target[j] >= 0
            if not hunts or gap > CLAIM_CM or not has_priority(fishes, minds, j, i):
                continue
            # A claim to its own target counts most.
            gap -= 2.0 * CLAIM_CM if minds.target[j] == minds.target[i] else 0.0
            if gap < nearest:
                minds.conceded[i], nearest = minds.target[j], gap


@kernel
def has_priority(fishes: Fishes, minds: Minds, j: int, i: int) -> bool:
    """True if predator i leaves a prey to predator j."""
    rushes, mine = minds.hunt[j] == RUSHING, minds.hunt[i] == RUSHING
    if rushes != mine:
        return bool(rushes)
    if fishes.length[j] != fishes.length[i]:
        return bool(fishes.length[j] > fishes.length[i])
    return j < i
