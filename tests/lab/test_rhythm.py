"""The rhythm of swimming: variation of speed, slow times and glides."""

import numpy as np
import pytest

from subsea.lab.rhythm import glides, rhythm
from subsea.repertoire import SEGMENTS
from tests.support.records import LENGTH, TICK_S, a_record

TICKS = 401
THOSE = np.array([0])
ALL = np.ones((TICKS, 1), bool)


def swimmer(speed, aside=0.0, **changed):
    """A fish that heads east at `speed` (T,) L/s, its tail `aside` (T,) L to its right."""
    way = np.cumsum(np.broadcast_to(speed, TICKS)) * TICK_S * LENGTH
    place = np.zeros((TICKS, 1, 3)) + (-400.0, 0.0, -200.0)
    place[:, 0, 0] += way
    record = a_record(place, **changed)
    record.tail[:, 0, 1] -= np.float32(np.broadcast_to(aside, TICKS) * LENGTH)
    return record


def test_a_steady_swim_varies_little():
    found = rhythm(swimmer(1.0), THOSE, ALL)
    assert found.variation == pytest.approx(0.0, abs=1e-3)
    assert found.slow == 0.0


def test_variation_is_the_deviation_of_the_speed_over_its_mean():
    """Two speeds for 10 s each in turn: 1 ± 0.8 L/s, slow below half of the median."""
    fast = np.arange(TICKS) // 100 % 2 == 0
    found = rhythm(swimmer(np.where(fast, 1.8, 0.2)), THOSE, ALL)
    assert found.variation == pytest.approx(0.8, rel=0.02)
    assert found.slow == pytest.approx(0.5, abs=0.02)


def test_only_chosen_ticks_count():
    fast = np.arange(TICKS) < 200
    record = swimmer(np.where(fast, 1.0, 0.1))
    assert rhythm(record, THOSE, fast[:, None]).slow == 0.0
    assert np.isnan(rhythm(record, THOSE, ALL & (np.arange(TICKS) < 50)[:, None]).variation)


def test_a_still_tail_glides_and_a_beating_one_does_not():
    """The tail beats at 1 Hz with 0.1 L from side to side, and keeps its place from 20 to 30 s."""
    time = np.arange(TICKS) * TICK_S
    still = (time >= 20.0) & (time < 30.0)
    aside = np.where(still, 0.0, 0.05 * np.sin(2 * np.pi * time))
    flags = glides(swimmer(1.0, aside), THOSE)[:, 0]
    assert (flags == still).mean() > 0.99
    assert rhythm(swimmer(1.0, aside), THOSE, ALL).gliding == pytest.approx(0.25, abs=0.01)


def test_a_fish_that_stands_or_rows_does_not_glide():
    assert glides(swimmer(1.0), THOSE).all()
    assert not glides(swimmer(0.02), THOSE).any()
    rows = np.full((TICKS, 1), SEGMENTS.index("row_forward"))
    assert not glides(swimmer(1.0, segment=rows), THOSE).any()


def test_a_record_shorter_than_a_glide_has_none():
    record = a_record(np.zeros((2, 1, 3)))
    assert glides(record, THOSE).shape == (2, 1)
    assert not glides(record, THOSE).any()
