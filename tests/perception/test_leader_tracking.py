"""Knowledge of schooling fishes about their leader."""

import numpy as np

from subsea.perception.leader_tracking import schools_of, see_leader, watch_leader, watch_schools

FOLLOWERS = np.array([1, 2])


def _school(tank):
    """A leader, a follower that sees it, and one from which a pillar hides it."""
    t = tank(3, pillars=[(50.0, -60.0, 30.0, -100.0)])
    t.fishes.position[:] = (100.0, 0.0, -300.0), (0.0, 0.0, -300.0), (0.0, -120.0, -300.0)
    t.minds.leader[1:], t.minds.led[:] = 0, True
    t.minds.schools[:] = True
    return t


def _watch(t, tick):
    seen = np.zeros(len(t.fishes.length), np.bool_)
    see_leader(FOLLOWERS, t.fishes, t.minds, t.sea, t.nature, seen)
    watch_leader(FOLLOWERS, t.fishes, t.minds, seen, t.at(tick).clock)


def test_a_fish_that_sees_its_leader_knows_its_place(tank):
    t = _school(tank)
    _watch(t, 100)
    np.testing.assert_allclose(t.minds.leader_place[1], t.fishes.position[0])
    assert t.minds.leader_seen[1] == np.float32(3.3)
    assert t.minds.leader_seen[2] == -np.inf


def test_companions_pass_on_the_place_of_the_leader(tank):
    t = _school(tank)
    t.minds.neighbour[2, 0] = 1
    _watch(t, 100)
    np.testing.assert_allclose(t.minds.leader_place[2], t.fishes.position[0])
    # Once all lose sight of it, they remember place and time.
    seen = t.fishes.position[0].copy()
    t.fishes.position[0] = 5000.0, 0.0, -300.0
    _watch(t, 200)
    np.testing.assert_allclose(t.minds.leader_place[1:], np.stack([seen, seen]))
    np.testing.assert_allclose(t.minds.leader_seen[1:], 3.3, rtol=1e-6)


def test_companions_of_another_school_pass_on_nothing(tank):
    t = _school(tank)
    t.minds.neighbour[2, 0] = 1
    t.minds.leader[1] = 2
    _watch(t, 100)
    assert t.minds.leader_seen[2] == -np.inf


def test_a_school_without_a_leader_knows_its_middle(tank):
    """Of the living that belong to it; a led fish knows its leader only."""
    t = tank(6)
    t.minds.schools[:], t.minds.leader[1:5], t.minds.led[4] = True, 0, True
    t.fishes.position[:] = np.arange(18.0).reshape(6, 3)
    t.fishes.alive[3] = False
    t.minds.light[:] = 1.0
    schools = schools_of(t.fishes, t.minds)
    watch_schools(np.arange(6), t.fishes, t.minds, t.nature, schools, t.at(10).clock)
    middle = t.fishes.position[:3].mean(axis=0)
    np.testing.assert_allclose(t.minds.leader_place[:3], np.tile(middle, (3, 1)), rtol=1e-6)
    assert t.minds.school_size[[0, 1, 2, 5]].tolist() == [3, 3, 3, 1]
    assert t.minds.leader_seen[0] > 0.3
    assert t.minds.leader_seen[4] == -np.inf
