"""Shape, spacing and splits of schools."""

import numpy as np
import pytest

from subsea.lab.schooling import LINK_BL, schools, split_periods, splits
from subsea.state import EAT, FEAR, SCHOOL, WANDER
from tests.support.records import EAST, NORTH, a_record, row


def a_school(offsets, ticks=41, intention=None, **changed):
    """Fishes led by the first, at `offsets` (n, 3) or (T, n, 3) from the middle, cm."""
    places = np.broadcast_to(np.array(offsets, float), (ticks, *np.shape(offsets)[-2:]))
    n = places.shape[1]
    leader = np.zeros((ticks, n), np.int32)
    leader[:, 0] = -1
    doing = np.full((ticks, n), SCHOOL)
    doing[:, 0] = WANDER
    return a_record(
        places - (0, 0, 200), leader=leader, intention=doing if intention is None else intention,
        **changed,
    )  # fmt: skip


def test_a_school_in_a_row():
    (school,) = schools(a_school(row(5, 1.2)))
    assert school.leader == 0
    assert (school.members == 5).all()
    assert school.cruises.all()
    assert school.polarisation == pytest.approx(1.0)
    assert school.distances == pytest.approx(1.2)
    assert (school.together == 1.0).all()
    assert len(school.time) == 21  # five times a second


def test_polarisation_is_the_length_of_the_mean_heading():
    turns = np.stack([EAST, EAST, NORTH, NORTH])
    (school,) = schools(a_school(row(4, 1.0), orientation=turns))
    assert school.polarisation == pytest.approx(0.5**0.5)


def test_a_body_length_is_that_of_both():
    (school,) = schools(a_school(row(3, 1.0), length=np.array([40.0, 20.0, 20.0])))
    assert school.distances.reshape(-1, 3)[0] == pytest.approx([2 / 3, 2 / 3, 1.0])


def test_members_with_other_intentions_do_not_count():
    places = np.vstack([row(4, 1.0), [[300.0, 0, 0]]])
    doing = np.tile([WANDER, SCHOOL, SCHOOL, SCHOOL, EAT], (41, 1))
    (school,) = schools(a_school(places, intention=doing))
    assert (school.together == 1.0).all()
    assert (school.members == 5).all()
    (school,) = schools(a_school(places))
    assert (school.together == 0.8).all()


def test_an_alarmed_school_does_not_cruise():
    mental = np.zeros((41, 5, 3), np.float32)
    mental[20:, 3, FEAR] = 0.6
    (school,) = schools(a_school(row(5, 1.0), mental_state=mental))
    assert school.cruises.sum() == 10
    assert len(school.distances) == 50


def test_nearest_and_connected_parts_are_those_of_all_pairs():
    rng = np.random.default_rng(2)
    for _ in range(20):
        places = rng.uniform(-150, 150, (12, 3)) * (1, 1, 0.3)
        length = rng.uniform(10, 30, 12)
        (school,) = schools(a_school(places, ticks=1, length=length))
        gap = np.linalg.norm(places[:, None] - places, axis=2)
        gap /= 0.5 * (length[:, None] + length)
        linked = np.linalg.matrix_power((gap <= LINK_BL).astype(float), 12) > 0
        np.fill_diagonal(gap, np.inf)
        assert school.distances == pytest.approx(gap.min(axis=1), rel=1e-5)
        assert school.together == pytest.approx(linked.sum(axis=1).max() / 12)


def test_a_split_lasts_until_nine_tenths_are_connected():
    """Three of ten are far away from 2 s to 6 s, and again at the end."""
    places = np.tile(row(10, 0.5), (101, 1, 1))
    places[20:60, 7:, 1] = 200.0
    places[80:, 7:, 1] = 200.0
    record = a_school(places, ticks=101)
    (school,) = schools(record)
    first, last = splits(school, float(record.time[-1]))
    assert (first.start, first.duration) == pytest.approx((2.1, 4.0))
    assert first.apart == pytest.approx(0.3)
    assert (first.rejoined, last.rejoined) == (True, False)
    assert last.duration == pytest.approx(2.0)


def test_a_split_ends_with_its_school():
    """Sampled every 0.2 s until 3.8 s, when predators have left too few fishes; in parts from 2."""
    time = np.arange(20) * 0.2
    together = np.where(time < 1.9, 1.0, 0.5)
    ((first, after, duration),) = split_periods(time, together, 300.0)
    assert (first, after) == (10, 20)
    assert duration == pytest.approx(2.0)


def test_one_of_ten_is_no_split():
    places = row(10, 0.5)
    places[9, 1] = 200.0
    (school,) = schools(a_school(places))
    assert splits(school, 4.1) == []
