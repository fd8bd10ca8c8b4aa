"""Turning aside from fishes and obstacles."""

import numpy as np
import pytest

from subsea.behavior import avoiding
from subsea.state import LEFT, PACIFIST, PREDATOR, PREY, RIGHT


def test_danger_is_all_or_nothing(tank):
    t = tank(3)
    t.minds.threat[1] = 0
    t.minds.barrier[2] = -2
    np.testing.assert_array_equal(t.desire(avoiding.desire), [0, 1, 1])


@pytest.mark.parametrize("side", [-1, 1])
def test_a_fish_turns_away_from_one_that_is_aside_and_lets_it_pass(tank, side):
    t = tank(2)
    t.fishes.position[1] = 15.0, 4.0 * side, -300.0
    t.minds.threat[0] = 1
    t.run(avoiding.act, 0)
    assert np.sign(t.minds.urge[0, 1]) == -side
    assert t.fishes.goal_speed[0] < 0.5
    # It does not wait for one behind.
    t.fishes.position[1, 0], t.fishes.goal_speed[0] = -10.0, 0.5
    t.run(avoiding.act, 0)
    assert t.fishes.goal_speed[0] == 0.5


@pytest.mark.parametrize(("preferred", "sign"), [(LEFT, 1), (RIGHT, -1)])
def test_straight_ahead_the_motor_preferences_decide(tank, preferred, sign):
    for what in ("threat", "barrier"):
        t = tank(2)
        t.fishes.position[1] = 15.0, 0.0, -300.0
        getattr(t.minds, what)[0] = 1
        t.minds.preference[0, preferred] = 0.5
        t.run(avoiding.act, 0)
        assert np.sign(t.minds.urge[0, 1]) == sign


def test_a_hunter_yields_to_no_prey(tank):
    one = tank(2)
    one.minds.threat[:] = 1, 0
    one.minds.kind[:] = PREDATOR, PREY
    assert one.desire(avoiding.desire).tolist() == [0, 1]
    one.minds.kind[1] = PACIFIST
    assert one.desire(avoiding.desire).tolist() == [1, 1]
