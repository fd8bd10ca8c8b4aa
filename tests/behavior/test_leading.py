"""Schools with a leader: following, spacing and speed."""

import numpy as np

from subsea.behavior import leading, schooling
from subsea.behavior.steering import ease_goals
from subsea.state import PREY
from tests.support.scenes import everyone


def _school(tank, n=3):
    t = tank(n)
    t.minds.leader[1:] = 0
    t.minds.schools[:] = t.minds.led[:] = True
    t.minds.kind[:] = PREY
    _see(t)
    return t


def _see(t):
    """Every follower knows the leader's place."""
    t.minds.leader_place[:] = t.fishes.position[0]
    t.minds.leader_seen[:] = 0.0


def test_stragglers_catch_up(tank):
    t = _school(tank)
    t.fishes.position[1] = -40.0, 0.0, -300.0
    t.fishes.position[2] = -400.0, 50.0, -300.0
    _see(t)
    for tick in range(30):
        t.at(tick).run(schooling.act, 1, 2)
        ease_goals(everyone(t.fishes), t.fishes, t.minds, t.clock)
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


def test_schooling_at_ease_needs_habit_leader_and_knowledge_of_company(tank):
    t = _school(tank, 4)
    t.minds.schools[2] = False
    np.testing.assert_array_equal(t.desire(schooling.desire) > 0, [False, True, False, True])
    later = t.at(int(2 * leading.LOST_S / 0.033))
    assert not later.desire(schooling.desire).any()
    t.minds.neighbour[1, 0] = 3
    np.testing.assert_array_equal(later.desire(schooling.desire) > 0, [False, True, False, False])


def test_a_leader_out_of_sight_is_sought_where_it_was_seen_last(tank):
    t = _school(tank, 2)
    t.fishes.position[1] = -200.0, 0.0, -300.0
    _see(t)
    t.fishes.position[0] = -200.0, 500.0, -300.0
    t.fishes.goal_direction[0] = 0.0, 1.0, 0.0
    t.at(100).run(schooling.act, 1)
    urge = t.minds.urge[1] / np.linalg.norm(t.minds.urge[1])
    np.testing.assert_allclose(urge, [1.0, 0.0, 0.0], atol=1e-5)


def test_an_alarmed_school_is_denser(tank):
    gaps = []
    for mood in (0.0, 1.0):
        t = _school(tank, 3)
        t.fishes.position[1:] = (-40.0, 12.0, -300.0), (-40.0, -12.0, -300.0)
        _see(t)
        t.minds.neighbour[1, 0], t.minds.neighbour[2, 0] = 2, 1
        t.minds.mood[:] = mood
        t.run(schooling.act, 1, 2)
        gaps.append(t.minds.urge[1, 1] - t.minds.urge[2, 1])
    assert gaps[0] > gaps[1]


def test_followers_beyond_the_reach_of_their_school_are_left_behind(tank):
    """Limit for eight followers of 20 cm: two body lengths times three."""
    t = tank(10)
    t.minds.leader[1:9] = 0
    t.minds.leader_seen[:] = 0.0
    assert not leading.leaves_behind(t.fishes, t.minds, 0, 1.0)
    t.fishes.position[1, 0] = 2.0 * leading.REACH_BL * 20.0 - 1.0
    assert not leading.leaves_behind(t.fishes, t.minds, 0, 1.0)
    t.fishes.position[1, 0] += 2.0
    assert leading.leaves_behind(t.fishes, t.minds, 0, 1.0)
    assert not leading.leaves_behind(t.fishes, t.minds, 0, leading.LOST_S + 1.0)  # long lost
    t.fishes.alive[1] = False
    assert not leading.leaves_behind(t.fishes, t.minds, 0, 1.0)


def test_one_of_many_is_not_waited_for(tank):
    t = tank(21)
    t.minds.leader[1:] = 0
    t.minds.leader_seen[:] = 0.0
    t.fishes.position[1:3, 0] = 900.0
    assert not leading.leaves_behind(t.fishes, t.minds, 0, 1.0)
    t.fishes.position[3, 0] = 900.0
    assert leading.leaves_behind(t.fishes, t.minds, 0, 1.0)


def test_a_fish_far_ahead_of_its_leader_comes_back(tank):
    """The leader slows down for a fish behind it, but does not halt if that is far away."""
    t = _school(tank, 3)
    t.fishes.goal_speed[0] = 0.1  # the leader waits, and heads for both
    t.fishes.position[1] = 60.0, 0.0, -300.0
    t.fishes.position[2] = 300.0, 0.0, -300.0
    _see(t)
    t.run(schooling.act, 1, 2)
    assert t.fishes.goal_speed[1] < 0.15
    assert t.fishes.goal_speed[2] > 0.5


def test_around_an_obstacle_it_rises_or_sinks_to_its_leader(tank):
    for height in (-250.0, -350.0):
        t = tank(2, pillars=[(120.0, 0.0, 30.0, 0.0)])
        t.minds.leader[1], t.minds.schools[:], t.minds.led[:] = 0, True, True
        t.fishes.position[0] = 240.0, 0.0, height
        t.fishes.position[1] = 0.0, 0.0, -300.0
        _see(t)
        t.run(schooling.act, 1)
        assert abs(t.minds.urge[1, 1]) > 0.3
        assert t.minds.urge[1, 2] * (height + 300.0) > 0.0
