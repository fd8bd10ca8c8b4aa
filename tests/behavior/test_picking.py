"""Picking plankton in a school that stays."""

import numpy as np
import pytest

from subsea.behavior import picking
from subsea.behavior.table import INTENTIONS
from subsea.state import HUNGER, PICK


@pytest.fixture
def school(tank):
    """Forty fishes of a school in company, by day."""
    t = tank(40)
    t.minds.schools[:], t.minds.leader[1:], t.minds.leads[0] = True, 0, True
    t.minds.neighbour[:, 0] = np.roll(np.arange(40), 1)
    t.minds.leader_place[:], t.minds.leader_seen[:] = t.fishes.position[0], 0.0
    t.minds.school_size[:] = 40.0
    t.fishes.identity[:] = np.linspace(0.0, 1.0, 40, endpoint=False)
    t.minds.mood[:] = -1.0
    return t


def _share(t, seconds=24.0):
    """Share of the time in which the fishes wish to pick."""
    wishes = [t.at(tick).desire(picking.desire) for tick in range(0, round(seconds / 0.033), 9)]
    return float((np.array(wishes) > 0.0).mean())


def test_its_code_is_that_of_the_table():
    assert INTENTIONS[PICK] == "pick"


def test_a_school_that_stays_picks_more_when_it_is_hungry(school):
    shares = []
    for hunger in (0.0, 1.0):
        school.minds.mental[:, HUNGER] = hunger
        shares.append(_share(school))
    np.testing.assert_allclose(shares, picking.OFTEN, atol=0.05)


@pytest.mark.parametrize("change", ["travels", "flees", "night", "led", "lost", "straggles"])
def test_others_do_not_pick(school, change):
    minds = school.minds
    if change in ("travels", "flees"):
        minds.mood[:] = 0.0 if change == "travels" else 1.0
    elif change == "night":
        school.sea.sky[1] = 0.0
    elif change == "led":
        minds.led[:] = True
    elif change == "lost":
        minds.neighbour[:, 0], minds.leader_seen[:] = -1, -np.inf
    else:
        minds.leader_place[:, 0] += 1000.0
        minds.leader[0] = 1
    assert _share(school, 6.0) == 0.0


def test_it_slows_down_and_snaps_once_in_an_attempt(school):
    """The catch covers some seconds of digestion; a full fish cannot eat more."""
    minds, fishes = school.minds, school.fishes
    minds.eaten[0], minds.appetite[0], minds.digestion[0] = 1.0, 3.0, 0.01
    minds.mental[0, HUNGER], minds.pause[0] = 0.6, 0.033
    meals, gapes = [], []
    for tick in range(1, 1 + round(3 * picking.PECK_S / 0.033)):
        fishes.gape[0] = 0.0
        before = minds.last_meal[0]
        t = school.at(tick)
        t.run(picking.act, 0)
        gapes.append(fishes.gape[0] > 0.0)
        meals.append(minds.last_meal[0] > before)
        assert fishes.goal_speed[0] == np.float32(picking.SLOW)
    assert sum(meals) == 3
    assert np.mean(gapes) == pytest.approx(1.0 - picking.SNAPS, abs=0.05)
    caught = 3 * picking.COVERS_S * 0.01 * 3.0
    assert minds.eaten[0] == pytest.approx(1.0 + caught, rel=0.1)


def test_fishes_turn_to_different_sides(school):
    school.minds.neighbour[:] = -1
    school.minds.leader_place[:] = school.fishes.position
    school.minds.waypoint[0] = school.fishes.position[0] + (900.0, 0.0, 0.0)
    school.at(30).run(picking.act, *range(40))
    sides = school.minds.urge[:, 1]
    assert (sides > 0.02).sum() > 8 and (sides < -0.02).sum() > 8
