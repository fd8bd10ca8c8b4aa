"""Schooling with neighbours: alignment, separation, attraction, destinations and joining."""

import numpy as np
import pytest

from subsea.behavior import leading, schooling
from subsea.behavior.school_goals import is_informed
from subsea.geometry.rotation import x_axis
from subsea.scenario.school_rules import USUAL
from subsea.state import FEAR, PREY
from subsea.state.school_rules import ATTENDED, ATTRACTION, NOISE_RAD, PACE_NOISE, REST
from subsea.world.populate import heading_quaternion

HERE = np.array([0.0, 0.0, -300.0])
AT_EASE = 0.95  # body lengths at which a neighbour neither repels nor attracts


def _school(tank, *places_bl, n=None):
    """Fishes of one school at places (body lengths of 20 cm) around the first."""
    t = tank(n or len(places_bl) + 1)
    t.minds.schools[:] = True
    t.minds.leader[1:] = 0
    t.minds.leads[0] = True
    t.fishes.position[:] = HERE
    t.fishes.position[1 : len(places_bl) + 1] += 20.0 * np.array(places_bl, float).reshape(-1, 3)
    t.minds.leader_place[:] = HERE
    t.minds.leader_seen[:] = 0.0
    t.minds.school_size[:] = len(t.minds.leader)
    t.minds.neighbour[0, : len(places_bl)] = np.arange(1, len(places_bl) + 1)
    return t


def _calm(t):
    """The same school without noise, and always on its way."""
    t.minds.rules[:, [NOISE_RAD, PACE_NOISE, REST]] = 0.0
    return t


def _urge(t, i=0):
    t.run(schooling.act, i)
    return t.minds.urge[i] / np.linalg.norm(t.minds.urge[i])


@pytest.mark.parametrize(("gap_bl", "sign"), [(0.4, -1.0), (AT_EASE, 0.0), (2.0, 1.0)])
def test_neighbours_repel_near_and_attract_far(tank, gap_bl, sign):
    """At a distance between the two only the heading, x, counts. The goal lies ahead."""
    t = _calm(_school(tank, (0.0, gap_bl, 0.0)))
    t.minds.waypoint[0] = HERE + (500.0, 0.0, 0.0)
    assert np.sign(np.round(_urge(t)[1], 6)) == sign


def test_by_night_a_school_at_ease_disperses_but_an_alarmed_one_stays_close(tank):
    ways = []
    for daylight, fear in ((1.0, 0.0), (0.0, 0.0), (0.0, 0.6)):
        t = _school(tank, (0.0, 1.5, 0.0))
        t.minds.waypoint[0] = HERE + (500.0, 0.0, 0.0)
        t.sea.sky[1], t.minds.mental[:, FEAR] = daylight, fear
        t.minds.mood[:] = 1.0 if fear > 0.0 else 0.0
        ways.append(_urge(t)[1])
    assert ways[0] > 0.0 > ways[1]
    assert ways[2] > 0.0


def test_it_aligns_with_neighbours(tank):
    t = _calm(_school(tank, (0, AT_EASE, 0), (0, -AT_EASE, 0)))
    t.minds.waypoint[0] = HERE
    north = np.array([0.5, 0.5, 0.5, 0.5])
    t.fishes.orientation[1:] = north
    expected = np.array([USUAL.inertia, USUAL.alignment, 0.0])
    np.testing.assert_allclose(_urge(t), expected / np.linalg.norm(expected), atol=1e-5)


@pytest.mark.parametrize("number", [1, 2])
def test_it_attends_to_as_many_neighbours_as_its_rules_say(tank, number):
    """The farther of two on the left is the second."""
    t = _calm(_school(tank, (0, AT_EASE, 0), (0, 3, 0)))
    t.minds.waypoint[0] = HERE
    t.minds.rules[0, ATTENDED] = number
    assert (_urge(t)[1] > 0.1) == (number == 2)


def test_it_keeps_the_speed_of_its_neighbours_and_hurries_behind_them(tank):
    speeds = []
    for ahead in (AT_EASE, 3.0):
        t = _calm(_school(tank, (ahead, 0.0, 0.0)))
        t.minds.rules[0, ATTRACTION] = 2.0
        t.fishes.velocity[1] = 0.7 * t.fishes.fast[0], 0.0, 0.0
        t.run(schooling.act, 0)
        speeds.append(float(t.fishes.goal_speed[0]))
    share = schooling.TENDENCY
    # Straight behind its neighbour it closes up, to have it as far aside as ahead.
    nudge = schooling.DIAGONAL_PACE * AT_EASE * (1 - share)
    expected = (1 - share) * 0.7 + share * schooling.CRUISING + nudge
    assert speeds[0] == pytest.approx(expected, abs=1e-4)
    assert speeds[1] > expected - nudge + 0.1


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_passes_an_obstacle_on_the_side_of_its_company(tank, side):
    """Though its own heading leads past on the other side."""
    t = _school(tank, (0, AT_EASE, 0), (0, -AT_EASE, 0), (-AT_EASE, 0, 0))
    t = t._replace(sea=t.sea._replace(pillars=np.array([[150.0, 0.0, 40.0, 0.0]])))
    t.minds.waypoint[0] = HERE + (600.0, 0.0, 0.0)
    t.fishes.orientation[0] = heading_quaternion(-0.15 * side)
    t.fishes.orientation[1:] = heading_quaternion(0.2 * side)
    for i in range(4):
        t.fishes.velocity[i] = 30.0 * np.array(x_axis(t.fishes.orientation[i]))
    assert side * _urge(t)[1] > 0.2


def test_few_know_the_destination(tank):
    """The one that the school is known by, and a fifth of the others, the same ones later."""
    t = tank(1)
    rule, later = t.minds.rules[0], t.at(3000).clock
    knows = [is_informed(i, 0, rule, t.clock) for i in range(2000)]
    assert knows[0]
    assert np.mean(knows) == pytest.approx(USUAL.informed, abs=0.005)
    assert 1 <= np.sum(knows[1:11]) <= 3
    assert knows == [is_informed(i, 0, rule, later) for i in range(2000)]


def test_a_fish_outside_its_school_heads_for_the_middle(tank):
    t = _school(tank, (0, AT_EASE, 0))
    t.minds.waypoint[0] = HERE
    t.minds.leader_place[0] = HERE + (0.0, 300.0, 0.0)
    assert _urge(t)[1] > 0.5


@pytest.mark.parametrize("fish", [0, 1])
def test_one_that_lost_its_school_returns_to_it(tank, fish):
    """Also the fish by which the school is known; but the last of a school has none."""
    t = _school(tank, n=3)
    t.minds.leader_place[:] = HERE + (0.0, 300.0, 0.0)
    t.minds.leader_seen[:] = t.clock.tick * t.clock.dt
    assert t.desire(schooling.desire)[fish] > 0.0
    assert _urge(t, fish)[1] > 0.5
    t.minds.school_size[:] = 1.0
    assert bool(t.desire(schooling.desire)[0] > 0.0) is False


def test_a_school_draws_a_destination_once_an_informed_fish_is_there(tank):
    t = _school(tank, (1, 0, 0))
    t.minds.patience[:] = 100.0
    t.minds.waypoint[:] = HERE + (1000.0, 0.0, 0.0)
    schooling.guide_schools(t.fishes, t.minds, t.sea, t.clock)
    np.testing.assert_allclose(t.minds.waypoint[0], HERE + (1000.0, 0.0, 0.0))
    t.fishes.position[0, 0] = 1000.0 - 5.0 * 20.0
    schooling.guide_schools(t.fishes, t.minds, t.sea, t.clock)
    assert np.linalg.norm(t.minds.waypoint[0] - HERE - (1000.0, 0.0, 0.0)) > 1.0
    np.testing.assert_allclose(t.minds.waypoint[1], HERE + (1000.0, 0.0, 0.0))


def test_an_errand_is_that_of_the_school(tank):
    t = _school(tank, (1, 0, 0))
    t.minds.neighbour[1, 0] = 0
    t.minds.errand[0] = 0.9
    assert (t.desire(schooling.desire) > 0.5).all()
    t.minds.led[:] = True
    assert not (t.desire(schooling.desire) > 0.5).any()


def test_ranks_are_closed_between_alarm_and_panic(tank):
    """f0 < F and F^m < f1 (Tu §7.5)."""
    t = _school(tank, n=5)
    t.minds.kind[:], t.minds.neighbour[:, 0] = PREY, 1
    t.minds.led[0] = True
    t.minds.mental[:, FEAR] = 0.4, 0.4, 0.6, 0.9, 0.9
    t.minds.menace[:] = 0.4, 0.4, 0.6, 0.7, 0.9
    np.testing.assert_allclose(t.desire(schooling.alarmed_desire), [0, 0, 0.6, 0.9, 0], atol=1e-6)


def test_loners_that_meet_form_a_school_and_others_join_it(tank):
    """Inception: the first follows the second, the leader; a third joins the same school."""
    t = tank(4)
    t.minds.schools[:3] = True
    t.minds.neighbour[0, :2] = 3, 1
    t.minds.neighbour[1, 0] = 0
    t.minds.neighbour[2, 0] = 0
    t.minds.neighbour[3, 0] = 0
    schooling.join_schools(np.arange(4), t.fishes.alive, t.minds)
    np.testing.assert_array_equal(t.minds.leader, [1, -1, 1, -1])
    np.testing.assert_array_equal(t.minds.leads, [False, True, False, False])


def test_nobody_joins_the_dead(tank):
    t = tank(2)
    t.minds.schools[:] = True
    t.minds.neighbour[0, 0] = 1
    t.fishes.alive[1] = False
    schooling.join_schools(np.arange(2), t.fishes.alive, t.minds)
    assert t.minds.leader[0] == -1


def test_a_straggler_is_far_from_its_leader_and_from_companions(tank):
    t = _school(tank, n=6)
    t.minds.leader_seen[:] = 0.0
    far = schooling.STRAGGLING_BL * 20.0
    t.fishes.position[1:, 0] = -far - 1.0, -far + 1.0, -far - 1.0, -far - 1.0, -far - 1.0
    t.minds.neighbour[3, : schooling.COMPANIONS] = 1, 2, 4, 5
    t.minds.neighbour[1, : schooling.COMPANIONS] = 3, 4, 5, 0  # the last is too far away
    t.minds.leader[4] = -1
    t.minds.leader_seen[5] = -leading.LOST_S
    found = [schooling.straggles(t.fishes, t.minds, i, 1.0) for i in range(6)]
    assert found == [False, True, False, False, False, False]
