"""Delays of direction in a school."""

import numpy as np
import pytest

from subsea.lab.leadership import leadership
from subsea.lab.report import measure
from subsea.state import SCHOOL
from tests.support.records import EAST, TICK_S, a_record, row

LAG_S = 0.15  # by which each fish of a row turns after the one ahead


def a_school(turning_rad, ticks=400, fishes=4):
    """Make a record of a row in which each fish turns after the one ahead, the last fish first."""
    place = np.arange(fishes)
    time = TICK_S * np.arange(ticks)[:, None] - LAG_S * (fishes - 1 - place)
    yaw = 0.5 * turning_rad * np.sin(2.0 * np.pi * time / 9.0)
    w, z = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    c, s = EAST[:2]
    turn = np.stack([w * c, w * s, z * s, z * c], axis=2)  # yaw after EAST
    position = np.tile(row(fishes, 1.0), (ticks, 1, 1))
    position[..., 2] = -200.0
    codes = np.full((ticks, fishes), SCHOOL)
    return a_record(position, turn, leader=0 * codes, intention=codes)


def test_who_turns_first_leads_and_swims_ahead():
    found = leadership(a_school(1.2), 0)
    assert found.fish.tolist() == [0, 1, 2, 3]
    assert np.diff(found.delay_s) == pytest.approx(np.full(3, LAG_S * 4 / 3), abs=0.02)
    assert found.first == 3
    assert found.front_correlation == pytest.approx(1.0, abs=0.01)
    assert found.front_bl == pytest.approx([-1.5, -0.5, 0.5, 1.5], abs=0.2)


def test_a_school_that_swims_straight_has_no_leader():
    found = leadership(a_school(0.0), 0)
    assert found.first is None
    assert np.isnan(found.front_correlation)


def test_a_fish_that_rarely_schools_does_not_count():
    school = a_school(1.2)
    school.intention[::3, 1], school.intention[1::3, 1] = 0 * SCHOOL + 6, 6
    assert leadership(school, 0).fish.tolist() == [0, 2, 3]


def test_the_report_has_leadership_and_spread():
    [school] = measure(a_school(1.2))["schools"]
    assert school["first_fish"] == 3
    delays = {one["fish"]: one["delay_s"] for one in school["each_fish"]}
    assert max(delays, key=delays.get) == 3 and delays[3] == school["first_by_s"]
    assert school["first_by_s"] == pytest.approx(LAG_S * 2.0, abs=0.03)
    assert school["front_leads"] == pytest.approx(1.0, abs=0.01)
    assert school["spread_bl"] == pytest.approx(np.sqrt(1.25), abs=0.01)  # of 0, 1, 2 and 3
    [straight] = measure(a_school(0.0, ticks=60))["schools"]
    assert straight["first_by_s"] is None and straight["front_leads"] is None
