"""Predators that notice each other, and which of them leaves a prey."""

import numpy as np
import pytest

from subsea.perception.grid import make_grid
from subsea.perception.rivals import CLAIM_CM, RIVAL_BL, has_priority, perceive_rivals
from subsea.state import EAT, NOBODY, PREDATOR, PREY, RUSHING, STALKING


@pytest.fixture
def pack(tank):
    """Three predators of 150, 120 and 120 cm along x, 2 m apart, and two prey."""
    t = tank(5)
    t.fishes.length[:] = 150.0, 120.0, 120.0, 17.0, 17.0
    t.fishes.position[:3, 0] = 0.0, 200.0, 400.0
    t.fishes.position[:3, 1:] = 0.0, -300.0
    t.minds.kind[:] = PREDATOR, PREDATOR, PREDATOR, PREY, PREY
    t.minds.intention[:3], t.minds.hunt[:3] = EAT, STALKING
    return t


def look(t):
    who = np.arange(5)
    perceive_rivals(who, t.fishes, t.minds, make_grid(t.fishes.position, np.arange(3), 400.0))
    return t.minds.rival[:3].tolist(), t.minds.conceded[:3].tolist()


def test_a_rival_is_the_nearest_predator_in_reach(pack):
    assert look(pack)[0] == [1, 0, 1] or look(pack)[0] == [1, 2, 1]
    pack.fishes.position[2, 0] = 200.0 + 1.1 * RIVAL_BL * 120.0
    assert look(pack)[0] == [1, 0, NOBODY]
    pack.fishes.alive[0] = False
    assert look(pack)[0] == [0, NOBODY, NOBODY] or look(pack)[0][1:] == [NOBODY, NOBODY]


def test_prey_belongs_to_the_larger_and_to_the_one_that_rushes(pack):
    t = pack
    t.minds.target[:3] = 3, 3, 4
    assert look(t)[1] == [NOBODY, 3, 3]
    t.minds.hunt[1] = RUSHING
    assert look(t)[1] == [3, NOBODY, 3]
    t.minds.target[2] = 3
    assert look(t)[1][2] == 3
    t.minds.target[1] = -1
    t.minds.hunt[1] = STALKING
    assert look(t)[1] == [NOBODY, 3, 3]
    t.fishes.position[0, 0] = 200.0 - 1.1 * CLAIM_CM
    assert look(t)[1] == [NOBODY, NOBODY, NOBODY]


def test_exactly_one_of_two_has_priority(pack):
    t = pack
    for i in range(3):
        for j in range(3):
            if i != j:
                first = has_priority(t.fishes, t.minds, i, j)
                assert first != has_priority(t.fishes, t.minds, j, i)
