"""Remove a fish that was eaten or landed from the memory of all others."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.periodic import nearest_image
from subsea.geometry.vector import dot, minus, norm, store, vector
from subsea.kernels import kernel
from subsea.state import MATE, NO_COURTSHIP, NOBODY, PREDATOR, Fishes, Minds
from subsea.state.places import place_near


@kernel
def remove(fishes: Fishes, minds: Minds, dead: int) -> None:
    """Mark fish `dead` as dead, and clear every reference to it.

    If it led a school, the frontmost of its followers leads now (Tu §7.9.2).
    """
    fishes.alive[dead] = False
    fishes.gape[dead] = 0.0
    pass_leadership(fishes, minds, dead)
    forget(minds, dead)


@kernel
def forget(minds: Minds, dead: int) -> None:
    """Clear fish `dead` from what others court, hunt, fear, avoid, accompany or like."""
    for i in range(len(minds.leader)):
        if minds.predator[i] == dead:
            minds.predator[i] = NOBODY
            minds.menace[i] = 0.0
        if minds.missed[i] == dead:
            minds.missed[i] = NOBODY
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
        for k in range(minds.liked.shape[1]):
            if minds.liked[i, k] == dead:
                minds.liked[i, k] = NOBODY
                minds.liking[i, k] = 0.0


@kernel
def _strike(row: Ints, dead: int) -> None:
    """Remove `dead` from a list that ends at the first NOBODY."""
    kept = 0
    for j in row:
        if j != dead:
            row[kept] = j
            kept += 1
    row[kept:] = NOBODY


@kernel
def pass_leadership(fishes: Fishes, minds: Minds, leader: int) -> None:
    """Make the frontmost follower of fish `leader` the leader of the others."""
    heir = _frontmost(fishes, minds, leader)
    for i in range(len(minds.leader)):
        if minds.leader[i] == leader:
            minds.leader[i] = heir if i != heir else NOBODY
    minds.leader[leader] = NOBODY
    minds.leads[leader] = False
    if heir != NOBODY:
        # A single follower has nobody left to lead.
        minds.leads[heir] = (minds.leader == heir).any()
        here = vector(fishes.position[heir])
        goal = nearest_image(vector(minds.waypoint[leader]), here, fishes.period)
        store(minds.waypoint[heir], goal)
        minds.patience[heir] = minds.patience[leader]


@kernel
def _frontmost(fishes: Fishes, minds: Minds, leader: int) -> int:
    """The living follower of `leader` farthest ahead along its heading, or NOBODY."""
    ahead, there = vector(fishes.goal_direction[leader]), vector(fishes.position[leader])
    if norm(ahead) < 1e-6:
        ahead = (1.0, 0.0, 0.0)
    best, farthest = NOBODY, -np.inf
    for i in range(len(minds.leader)):
        if minds.leader[i] == leader and fishes.alive[i]:
            lead = dot(minus(place_near(fishes, i, there), there), ahead)
            if lead > farthest:
                best, farthest = i, lead
    return best
