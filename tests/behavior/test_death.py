"""Effects of a fish's death on the other fishes."""

import numpy as np

from subsea.behavior.death import remove
from subsea.behavior.table import BEHAVIORS, TABLE
from subsea.state import (
    APPROACHING,
    MATE,
    NO_COURTSHIP,
    NOBODY,
    PACIFIST,
    PREDATOR,
    Fishes,
    Minds,
    empty,
)


def _some(n):
    fishes, minds = empty(Fishes, n=n), empty(Minds, n=n, b=len(BEHAVIORS), d=len(TABLE.desires))
    fishes.goal_direction[:, 0] = 1.0
    return fishes, minds


def test_the_frontmost_follower_leads_the_school_on():
    fishes, minds = _some(5)
    minds.leader[1:4] = 0
    minds.leads[0] = True
    fishes.position[:, 0] = 0.0, -30.0, -10.0, -20.0, 50.0  # the last one is of another school
    remove(fishes, minds, 0)
    assert fishes.alive.tolist() == [False, True, True, True, True]
    assert minds.leader.tolist() == [NOBODY, 2, NOBODY, 2, NOBODY]
    assert minds.leads.tolist() == [False, False, True, False, False]


def test_a_dead_follower_is_no_heir_and_one_that_is_left_leads_nobody():
    fishes, minds = _some(3)
    minds.leader[1:] = 0
    fishes.position[:, 0] = 0.0, 20.0, -20.0
    remove(fishes, minds, 1)
    assert minds.leader.tolist() == [NOBODY, NOBODY, 0]
    remove(fishes, minds, 0)
    assert (minds.leader == NOBODY).all()
    assert not minds.leads.any()


def test_nobody_points_to_the_dead():
    fishes, minds = _some(4)
    minds.kind[:] = PREDATOR, PACIFIST, PACIFIST, PACIFIST
    minds.target[:] = 3
    minds.food[:] = 3  # of a pacifist: a speck
    minds.intention[1] = MATE
    minds.memory[1] = MATE
    minds.memory_target[:] = 3
    minds.neighbour[1, :3] = 2, 3, 0
    minds.foods[:2], minds.predators[2], minds.mates[1] = (1, 3, -1), (3, 0, -1), (2, 3, -1)
    minds.mate[1], minds.partner[1], minds.courtship[1] = 3, 3, APPROACHING
    minds.predator[2], minds.menace[2], minds.threat[2] = 3, 0.9, 3
    remove(fishes, minds, 3)
    assert minds.target.tolist() == [NOBODY, NOBODY, 3, 3]
    assert minds.memory_target.tolist() == [NOBODY, NOBODY, 3, 3]
    assert minds.food.tolist() == [NOBODY, 3, 3, 3]
    assert minds.neighbour[1, :3].tolist() == [2, 0, NOBODY]
    assert minds.foods[:2].tolist() == [[1, NOBODY, NOBODY], [1, 3, NOBODY]]
    assert minds.predators[2].tolist() == [0, NOBODY, NOBODY]
    assert minds.mates[1].tolist() == [2, NOBODY, NOBODY]
    assert minds.mate[1] == minds.partner[1] == NOBODY
    assert minds.courtship[1] == NO_COURTSHIP
    assert minds.predator[2] == minds.threat[2] == NOBODY
    assert minds.menace[2] == 0
    assert np.isinf(minds.mate_distance[1])
