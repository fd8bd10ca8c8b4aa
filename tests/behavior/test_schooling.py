"""Company: following, spacing, pace, and who wants it."""

import numpy as np

from subsea.behavior import schooling
from subsea.behavior.steering import heed
from subsea.state import FEAR, PREY


def _school(tank, n=3):
    t = tank(n)
    t.minds.leader[1:] = 0
    t.minds.schools[:] = True
    t.minds.kind[:] = PREY
    return t


def test_stragglers_catch_up(tank):
    t = _school(tank)
    t.fishes.position[1] = -40.0, 0.0, -300.0
    t.fishes.position[2] = -400.0, 50.0, -300.0
    for tick in range(30):
        t.at(tick).run(schooling.act, 1, 2)
        heed(t.fishes, t.minds, t.clock)
    toward = t.fishes.position[0] - t.fishes.position[2]
    assert t.fishes.goal_direction[2] @ toward / np.linalg.norm(toward) > 0.9
    assert t.fishes.goal_speed[2] > t.fishes.goal_speed[1]


def test_companions_too_close_part(tank):
    t = _school(tank)
    t.fishes.position[1] = -60.0, 3.0, -300.0
    t.fishes.position[2] = -60.0, -3.0, -300.0
    t.minds.neighbour[1, 0], t.minds.neighbour[2, 0] = 2, 1
    t.run(schooling.act, 1, 2)
    assert t.minds.urge[1, 1] > 0 > t.minds.urge[2, 1]


def test_schooling_at_ease_needs_habit_and_leader(tank):
    t = _school(tank)
    t.minds.schools[2] = False
    np.testing.assert_array_equal(t.desire(schooling.desire) > 0, [False, True, False])
    t.fishes.alive[0] = False
    assert not t.desire(schooling.desire).any()


def test_ranks_are_closed_between_alarm_and_panic(tank):
    """f0 < F and F^m < f1 (Tu §7.5)."""
    t = _school(tank, 5)
    t.minds.mental[:, FEAR] = 0.4, 0.4, 0.6, 0.9, 0.9
    t.minds.menace[:] = 0.4, 0.4, 0.6, 0.7, 0.9
    np.testing.assert_allclose(t.desire(schooling.alarmed_desire), [0, 0, 0.6, 0.9, 0], atol=1e-6)
