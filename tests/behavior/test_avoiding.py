"""Turning aside from fishes and obstacles."""

import numpy as np
import pytest

from subsea.behavior import avoiding
from subsea.state import (
    AVOID,
    ESCAPE,
    FEAR,
    LEFT,
    PACIFIST,
    PREDATOR,
    PREY,
    RIGHT,
    SCHOOL,
    SEABED,
    SURFACE,
    WALL,
)


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
        t = tank(2, pillars=[(900.0, 0.0, 10.0, 0.0), (30.0, 0.0, 10.0, 0.0)])
        t.fishes.position[1] = 15.0, 0.0, -300.0
        getattr(t.minds, what)[0] = 1
        t.minds.preference[0, preferred] = 0.5
        t.run(avoiding.act, 0)
        assert np.sign(t.minds.urge[0, 1]) == sign


@pytest.mark.parametrize("side", [-1, 1])
def test_a_fish_passes_a_solid_on_the_side_on_which_it_is(tank, side):
    t = tank(2, pillars=[(30.0, 5.0 * side, 10.0, 0.0)], rocks=[(30, 5 * side, -300, 9, 9, 9, 0)])
    t.minds.barrier[:], t.minds.preference[:, LEFT] = (0, 1), 0.1 * side
    t.run(avoiding.act)
    assert np.sign(t.minds.urge[:, 1]).tolist() == [-side, -side]


@pytest.mark.parametrize("side", [-1, 1])
def test_a_fish_between_two_stones_keeps_turning_to_one_side(tank, side):
    t = tank(pillars=[(30.0, 5.0, 10.0, 0.0), (30.0, -5.0, 10.0, 0.0)])
    first = (1 + side) // 2
    for k, busy in ((first, 0.0), (1 - first, 0.033), (first, 0.066)):
        t.minds.barrier[0], t.minds.busy[0] = k, busy
        t.run(avoiding.act)
        assert np.sign(t.minds.urge[0, 1]) == (1 if first else -1)
    t.minds.barrier[0], t.minds.busy[0] = 1 - first, 0.0  # another reaction
    t.run(avoiding.act)
    assert np.sign(t.minds.urge[0, 1]) == (-1 if first else 1)


@pytest.mark.parametrize("side", [-1, 1])
def test_a_fish_turns_inward_from_the_wall(tank, side):
    t = tank()
    t.fishes.position[0] = 900.0, 300.0 * side, -300.0
    t.minds.barrier[0] = WALL
    t.run(avoiding.act)
    assert np.sign(t.minds.urge[0, 1]) == -side


@pytest.mark.parametrize(("barrier", "sign"), [(SEABED, 1), (SURFACE, -1)])
def test_a_fish_climbs_from_the_seabed_and_dives_from_the_surface(tank, barrier, sign):
    t = tank()
    t.minds.barrier[0] = barrier
    t.run(avoiding.act)
    assert np.sign(t.minds.urge[0, 2]) == sign
    assert t.minds.urge[0, 1] == pytest.approx(0.0, abs=1e-6)


def test_where_both_sides_are_equal_chance_decides_once_for_each_encounter(tank):
    """A reaction has one side in all its ticks; one that begins later has its own."""
    n = 200

    def sides(tick, began=40, seed=1):
        t = tank(n + 2, seed=seed).at(tick)
        t.fishes.position[n:] = 15.0, 0.0, -300.0
        t.minds.threat[:n] = n + tick % 2
        t.minds.busy[:n] = (tick - began) * t.clock.dt
        t.run(avoiding.act, *range(n))
        return np.sign(t.minds.urge[:n, 1])

    first = sides(40)
    assert 0.35 < (first > 0).mean() < 0.65
    for tick in (41, 47, 60, 3000):
        assert (sides(tick) == first).all()
    for others in (sides(40, seed=2), sides(41, began=41)):
        assert 0.3 < (others == first).mean() < 0.7


def test_a_hunter_yields_to_no_prey(tank):
    one = tank(2)
    one.minds.threat[:] = 1, 0
    one.minds.kind[:] = PREDATOR, PREY
    assert one.desire(avoiding.desire).tolist() == [0, 1]
    one.minds.kind[1] = PACIFIST
    assert one.desire(avoiding.desire).tolist() == [1, 1]


@pytest.mark.parametrize(("length", "yields"), [(3.9, [0, 1]), (4.1, [1, 1])])
def test_a_large_fish_yields_to_no_small_one(tank, length, yields):
    t = tank(2)
    t.minds.threat[:], t.fishes.length[1] = (1, 0), length
    assert t.desire(avoiding.desire).tolist() == yields


def test_prey_in_panic_minds_its_predator_alone(tank):
    t = tank(2)
    t.minds.threat[0], t.minds.barrier[0], t.minds.kind[:] = 1, -2, (PREY, PREDATOR)
    assert t.desire(avoiding.desire)[0] == 1
    t.minds.menace[0] = t.nature.panicked
    assert t.desire(avoiding.desire)[0] == 0
    t.minds.menace[0] = 0.0
    t.minds.barrier[0], t.minds.mental[0, FEAR] = -1, 0.9 * t.nature.alarmed
    assert t.desire(avoiding.desire)[0] == 1
    t.minds.mental[0, FEAR] = 1.1 * t.nature.alarmed  # it flees the predator instead
    assert t.desire(avoiding.desire)[0] == 0


def test_prey_that_flees_avoids_no_other_fish(tank):
    t = tank(2)
    t.minds.threat[0], t.minds.kind[:], t.minds.intention[0] = 1, PREY, ESCAPE
    for fear, yields in ((0.9, 1), (1.1, 0)):
        t.minds.mental[0, FEAR] = fear * t.nature.alarmed
        assert t.desire(avoiding.desire)[0] == yields


def test_a_fish_that_inspects_makes_room_as_in_its_school(tank):
    t = tank(2)
    t.minds.threat[0], t.minds.leader[1], t.minds.intention[1] = 1, 0, SCHOOL
    assert t.desire(avoiding.desire)[0] == 1
    t.minds.inspection[0] = 1.0
    assert t.desire(avoiding.desire)[0] == 0


def test_fishes_of_a_school_make_room_by_schooling(tank):
    t = tank(3)
    t.minds.leader[1], t.minds.threat[:], t.minds.intention[:] = 0, (1, 2, 1), SCHOOL
    assert t.desire(avoiding.desire).tolist() == [0, 1, 1]
    t.minds.intention[1] = AVOID
    assert t.desire(avoiding.desire)[0] == 1


def test_it_keeps_its_course_once_the_danger_has_passed(tank):
    t = tank()
    t.minds.urge[0], t.fishes.goal_speed[0] = (0.0, 1.0, 0.0), 0.9
    t.run(avoiding.act)
    assert t.minds.urge[0].tolist() == [0.0, 1.0, 0.0]
    assert t.fishes.goal_speed[0] == np.float32(0.9)
