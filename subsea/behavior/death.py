"""What becomes of the others when a fish is gone: eaten, or landed."""

import numpy as np

from subsea.core.arrays import Ints
from subsea.core.kernels import kernel
from subsea.geometry.vector import dot, minus, norm, vector
from subsea.state import MATE, NO_COURTSHIP, NOBODY, PREDATOR, Fishes, Minds


@kernel
def remove(fishes: Fishes, minds: Minds, dead: int) -> None:
    """Fish `dead` is no longer alive; nobody follows, courts, hunts or fears it any more.

    Its school, if it led one, is led by the frontmost of those who followed (Tu §7.9.2).
    """
    fishes.alive[dead] = False
    fishes.gape[dead] = 0.0
    pass_leadership(fishes, minds, dead)
    forget(minds, dead)


@kernel
def forget(minds: Minds, dead: int) -> None:
    """Let nobody court, hunt, fear, avoid or accompany fish `dead` any more."""
    for i in range(len(minds.leader)):
        if minds.predator[i] == dead:
            minds.predator[i] = NOBODY
            minds.menace[i] = 0.0
        if minds.threat[i] == dead:
            minds.threat[i] = NOBODY
        if minds.mate[i] == dead:
            minds.mate[i] = NOBODY
            minds.mate_distance[i] = np.inf
        if minds.partner[i] == dead:
            minds.partner[i] = NOBODY
            minds.courtship[i] = NO_COURTSHIP
        hunts = minds.kind[i] == PREDATOR
        if minds.target[i] == dead and (hunts or minds.intention[i] == MATE):
            minds.target[i] = NOBODY
        if minds.memory_target[i] == dead and (hunts or minds.memory[i] == MATE):
            minds.memory_target[i] = NOBODY
        if hunts and minds.food[i] == dead:
            minds.food[i] = NOBODY
            minds.food_distance[i] = np.inf
        if hunts:
            _strike(minds.foods[i], dead)
        _strike(minds.predators[i], dead)
        _strike(minds.mates[i], dead)
        _strike(minds.neighbour[i], dead)


@kernel
def _strike(row: Ints, dead: int) -> None:
    """Take `dead` out of a list that ends at the first NOBODY: those who come after move up."""
    kept = 0
    for j in row:
        if j != dead:
            row[kept] = j
            kept += 1
    row[kept:] = NOBODY


@kernel
def pass_leadership(fishes: Fishes, minds: Minds, leader: int) -> None:
    """Let the frontmost of those who follow fish `leader` lead them; it follows nobody itself."""
    heir = _frontmost(fishes, minds, leader)
    for i in range(len(minds.leader)):
        if minds.leader[i] == leader:
            minds.leader[i] = heir if i != heir else NOBODY
    minds.leader[leader] = NOBODY
    minds.leads[leader] = False
    if heir != NOBODY:
        # With a single follower nobody is left to be led.
        minds.leads[heir] = (minds.leader == heir).any()


@kernel
def _frontmost(fishes: Fishes, minds: Minds, leader: int) -> int:
    """Of the living followers of `leader` the one farthest ahead along its heading, or NOBODY."""
    ahead, there = vector(fishes.goal_direction[leader]), vector(fishes.position[leader])
    if norm(ahead) < 1e-6:
        ahead = (1.0, 0.0, 0.0)
    best, farthest = NOBODY, -np.inf
    for i in range(len(minds.leader)):
        if minds.leader[i] == leader and fishes.alive[i]:
            lead = dot(minus(vector(fishes.position[i]), there), ahead)
            if lead > farthest:
                best, farthest = i, lead
    return best
