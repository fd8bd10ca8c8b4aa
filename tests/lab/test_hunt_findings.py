"""Hunts beside their aims: rushes at close range, and the room between two hunters."""

import numpy as np
import pytest

from subsea.base.findings import FAIL, PASS
from subsea.fish.measured import load_measured
from subsea.lab.hunt_findings import close_rushes, hunt_findings, joined
from subsea.lab.hunting import hunts
from subsea.lab.measures import PERIOD_S
from subsea.state import EAT, PREDATOR, PREY
from tests.support.records import LENGTH, TICK_S, a_record

FACTS = load_measured().predation


def a_hunt(starts, apart_bl=0.5, ticks=600, beside_bl=5.0):
    """A hunter of 20 cm that rushes for 1 s at 3 L/s to `apart_bl` before a prey, from `starts` s.

    Before each it is carried back. Another hunter stands `beside_bl` aside.
    """
    x = np.full(ticks, -400.0)
    for start in starts:
        first = round(start / TICK_S)
        way = np.arange(11) * 3.0 * LENGTH * TICK_S
        x[first:] = -400.0
        x[first : first + 11] = -8.0 - apart_bl * LENGTH - way[-1] + way
        x[first + 11 :] = x[first + 10]
    place = np.zeros((ticks, 3, 3)) - (0, 0, 200)
    place[:, 0, 0] = x
    place[:, 2] = (-400.0, beside_bl * LENGTH, -200.0)
    kind = np.array([PREDATOR, PREY, PREDATOR], np.uint8)
    doing = np.zeros((ticks, 3), np.uint8) + EAT
    target = np.full((ticks, 3), -1)
    target[:, 0] = 1
    return a_record(place, kind=kind, intention=doing, target=target)


def rows(*records, wanted=True):
    found = hunt_findings("sea", [hunts(one) for one in records], FACTS, wanted)
    return {one.quantity: one for one in found}


NUMBER, FIRST = "rushes at close range in 3 min, fewest", "first rush at close range, latest"


def test_rushes_at_close_range_are_counted_for_three_minutes():
    seen = close_rushes(hunts(a_hunt([12.0, 30.0])))
    assert seen[0] == pytest.approx(2 * PERIOD_S / 60.0)
    assert seen[1] == pytest.approx(12.0, abs=0.5)
    assert close_rushes(hunts(a_hunt([12.0], apart_bl=1.6))) == (0.0, pytest.approx(60.0))


def test_the_run_with_the_fewest_and_the_latest_counts():
    found = rows(a_hunt([5.0, 20.0]), a_hunt([50.0]))
    assert found[NUMBER].value == pytest.approx(3.0)
    assert found[NUMBER].verdict == PASS
    assert found[FIRST].value == pytest.approx(50.0, abs=0.5)
    assert found[FIRST].verdict == FAIL
    assert rows(a_hunt([]))[NUMBER].verdict == FAIL
    assert rows(a_hunt([]), wanted=False)[NUMBER].verdict == "–"


def test_two_hunters_must_not_touch():
    """They are abreast: the mean of half-width and half-height of each is 2 cm."""
    name = "least gap between two hunters"
    apart, touching = (rows(a_hunt([], beside_bl=far))[name] for far in (0.5, 0.15))
    assert apart.value == pytest.approx(10.0 - 4.0, abs=0.1)
    assert (apart.verdict, touching.verdict) == (PASS, FAIL)


def test_parts_of_a_dive_are_joined():
    whole = a_hunt([12.0, 30.0])
    parts = []
    for part in (slice(0, 250), slice(250, 600)):
        cut = {
            name: value[part]
            for name, value in whole._asdict().items()
            if isinstance(value, np.ndarray) and len(value) == 600
        }
        parts.append(hunts(whole._replace(**cut)))
    found, once = joined(parts), hunts(whole)
    assert found.seconds == pytest.approx(60.0)
    assert [one.start_s for one in found.rushes] == [one.start_s for one in once.rushes]
    assert found.least_gap_cm == once.least_gap_cm
