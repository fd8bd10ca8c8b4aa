"""Measures of hunts, from tracks of a hunter and its prey in closed form."""

import numpy as np
import pytest

from subsea.lab.hunting import RUSHES_BL_S, hunts, least_gap, speed_of
from subsea.state import EAT, PREDATOR, PREY, WANDER
from tests.support.records import EAST, LENGTH, TICK_S, a_record

TICKS = 200
SLOW, FAST = 0.5, 2.5  # L/s


def a_hunt(start=100, ticks=12, below=0.0, companions=0, dies=None, turned=False):
    """A hunter along x that stalks from tick 50, rushes for `ticks` ticks, and wanders again."""
    time = np.arange(TICKS)
    speed = np.where((time >= start) & (time < start + ticks), FAST, SLOW)
    x = np.cumsum(speed) * TICK_S * LENGTH
    far = x[start] + (0.4 + 2.0) * LENGTH
    places = np.zeros((TICKS, 2 + companions, 3), np.float32)
    places[:, 0, 0], places[:, :, 2] = x, -200.0
    places[:, 1:, 0] = far
    places[:, 1:, 2] += below * LENGTH
    places[:, 2:, 1] = 10.0 * (1 + np.arange(companions))
    kind = np.array([PREDATOR] + [PREY] * (1 + companions))
    intention = np.full(places.shape[:2], WANDER)
    intention[50 : start + ticks + 2, 0] = EAT
    target = np.full(places.shape[:2], -1)
    target[50 : start + ticks, 0] = 1
    alive = np.ones(places.shape[:2], bool)
    meal = np.zeros(places.shape[:2], np.float32)
    if dies is not None:
        alive[dies:, 1] = False
        meal[dies:, 0] = TICK_S * (dies + 1)
    turns = np.broadcast_to(EAST, (*places.shape[:2], 4)).copy()
    if turned:  # the prey faces the hunter
        turns[:, 1] = 0.0, 0.0, 0.5**0.5, 0.5**0.5
    return a_record(places, turns, kind=kind, intention=intention, target=target, alive=alive,
                    last_meal=meal)  # fmt: skip


def test_the_phases_of_a_hunt_have_their_times_and_speeds():
    found = hunts(a_hunt())
    assert found.patrol_share == pytest.approx((TICKS - 64) / TICKS)
    assert found.patrol_bl_s == pytest.approx(SLOW, abs=0.02)
    assert found.stalks == [pytest.approx(50 * TICK_S, abs=0.21)]
    (rush,) = found.rushes
    assert (rush.hunter, rush.prey, rush.hit, rush.school) == (0, 1, False, False)
    assert rush.start_s == pytest.approx(101 * TICK_S, abs=0.21)
    assert rush.duration_s == pytest.approx(12 * TICK_S, abs=0.21)
    assert rush.start_bl == pytest.approx(2.0, abs=0.3)
    assert rush.peak_bl_s == pytest.approx(FAST, rel=0.05)
    assert rush.close
    assert found.caught_s == []


def test_the_approach_is_from_below_or_behind():
    (level,) = hunts(a_hunt()).rushes
    assert (level.below, level.behind, level.hidden) == (False, True, True)
    (deep,) = hunts(a_hunt(below=0.7, turned=True)).rushes
    assert (deep.below, deep.behind, deep.hidden) == (True, False, False)
    (deep,) = hunts(a_hunt(below=1.0, turned=True)).rushes
    assert deep.hidden


def test_companions_make_a_school_and_a_death_a_hit():
    (rush,) = hunts(a_hunt(companions=3, dies=110)).rushes
    assert (rush.school, rush.hit) == (True, True)
    (rush,) = hunts(a_hunt(companions=1, dies=180)).rushes
    assert (rush.school, rush.hit) == (False, False)
    assert len(hunts(a_hunt(dies=110)).caught_s) == 1


def test_neither_a_moment_nor_fast_patrol_is_a_rush():
    assert hunts(a_hunt(ticks=2)).rushes == []
    calm = a_hunt()
    calm = calm._replace(intention=np.full_like(calm.intention, WANDER))
    assert hunts(calm).rushes == []
    assert speed_of(calm, 0).max() > RUSHES_BL_S


def test_the_gap_of_two_hunters_is_between_their_skins():
    """Bodies of spheres with a radius of 2 cm, abreast and nose to tail."""
    for place, gap in (((0.0, 10.0, 0.0), 6.0), ((1.5 * LENGTH, 0, 0), 6.0), ((0, 3.0, 0), -1.0)):
        both = np.zeros((3, 2, 3), np.float32)
        both[:, 1] = place
        record = a_record(both - (0, 0, 200), kind=np.array([PREDATOR] * 2))
        assert least_gap(record, np.array([0, 1])) == pytest.approx(gap, abs=0.6)


def test_a_sea_without_hunters_has_no_hunts():
    found = hunts(a_record(np.zeros((20, 2, 3)), kind=np.array([PREY, PREY])))
    assert (found.stalks, found.rushes, found.caught_s) == ([], [], [])
    assert np.isnan(found.patrol_share)
    assert found.least_gap_cm == np.inf
