"""Schools: shape, spacing and splits."""

import numpy as np
import pytest

from subsea.lab.schooling import (
    BEARINGS,
    LINK_BL,
    SECTORS,
    joined,
    proportions,
    room_of,
    rotation_of,
    schooling,
    schools,
    split_periods,
    splits,
    states,
)
from subsea.state import EAT, FEAR, SCHOOL, WANDER
from tests.support.records import EAST, LENGTH, NORTH, a_record, row


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


def still_school(places, ticks=31):
    n = len(places)
    leader = np.zeros((ticks, n), np.int32)
    leader[:, 0] = -1
    still = np.broadcast_to(places * LENGTH - (0, 0, 200.0), (ticks, n, 3))
    return a_record(still, leader=leader, intention=np.full((ticks, n), SCHOOL))


def test_a_ball_of_fishes_has_the_room_of_a_ball():
    rng = np.random.default_rng(3)
    ball = rng.normal(size=(400, 3))
    ball *= (rng.uniform(0, 1, 400) ** (1 / 3) / np.linalg.norm(ball, axis=1))[:, None] * 3.0
    (found,) = schooling(still_school(ball, ticks=3))
    assert found.fishes == 400
    assert found.room_bl3 == pytest.approx(4 / 3 * np.pi * 27 / 400, rel=0.1)
    assert found.bearing == pytest.approx(1 / BEARINGS, abs=0.05)
    assert found.polarisation == pytest.approx(1.0)


def lattice(room, shape):
    """Places of a cubic lattice with this room for each point, within an ellipsoid."""
    side = room ** (1 / 3)
    points = np.moveaxis(np.mgrid[-12:13, -12:13, -12:13], 0, -1).reshape(-1, 3) * side
    return points[np.linalg.norm(points / shape, axis=1) < 1.0]


@pytest.mark.parametrize("room", [0.7, 1.4])
def test_a_lattice_has_its_known_room(room):
    assert room_of(lattice(room, (7.0, 5.0, 3.0))) == pytest.approx(room, rel=0.06)


def test_stragglers_add_no_room():
    """One fish of 14 is three times as far from the middle as it would be."""
    places = lattice(1.0, (7.0, 5.0, 3.0))
    scattered = places.copy()
    scattered[::14] *= 3.0
    assert room_of(scattered) == pytest.approx(room_of(places), rel=0.15)


def test_few_fishes_or_a_plane_have_no_room():
    places = np.random.default_rng(4).normal(size=(20, 3))
    assert np.isnan(room_of(places[:9]))
    assert np.isnan(room_of(places * (1, 1, 0)))
    assert room_of(places) > 0.0


def test_files_have_their_neighbours_ahead_and_behind():
    """Two files at different depths: the nearest is in the same file; the first leads by 2 L."""
    x = np.array([0.0, 0.8, 1.6, 2.4, 4.4])
    places = np.concatenate(
        [np.stack([x, 0 * x, 0 * x], 1), np.stack([x - 3, 0 * x, 2 + 0 * x], 1)]
    )
    (found,) = schooling(still_school(places))
    assert found.nearest_bl == pytest.approx(0.8, rel=1e-4)
    assert found.height_bl == 0.0
    assert found.ahead_bl == pytest.approx(2.0, rel=1e-4)
    assert found.bearing[0] + found.bearing[-1] == pytest.approx(1.0)
    assert found.split_s.shape == (0,)


def ring(n=12):
    """Places (n, 3) on a circle and headings (n, 3) along it, to the left."""
    angle = np.linspace(0.0, 2 * np.pi, n, endpoint=False)
    out = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return 100.0 * out, np.stack([-out[:, 1], out[:, 0], 0 * angle], axis=1)


def test_a_mill_rotates_and_a_file_does_not():
    place, along = ring()
    assert rotation_of(place, along) == pytest.approx(1.0)
    assert rotation_of(place, -along) == pytest.approx(1.0)
    assert rotation_of(place, np.tile([1.0, 0, 0], (12, 1))) == pytest.approx(0.0, abs=1e-9)
    assert rotation_of(place, place / 100.0) == pytest.approx(0.0, abs=1e-9)


def test_states_are_told_by_both_orders():
    (school,) = schools(a_school(row(5, 1.2), ticks=12))
    school = school._replace(
        polarisation=np.array([0.9, 0.9, 0.1, 0.2, 0.5, 0.9]),
        rotation=np.array([0.1, 0.2, 0.9, 0.1, 0.5, 0.5]),
        calm=np.array([True, False, True, True, True, True]),
    )
    assert states(school) == pytest.approx({"polarised": 0.2, "milling": 0.2, "swarm": 0.2})
    assert set(states(school._replace(calm=np.zeros(6, bool))).values()) == {0.0}


def test_a_school_of_fishes_on_a_circle_mills():
    place, along = ring()
    half = 0.5 * np.arctan2(along[:, 1], along[:, 0])
    # EAST turned to the left about the vertical.
    turns = 0.5**0.5 * np.stack([np.cos(half), np.cos(half), np.sin(half), np.sin(half)], axis=1)
    record = still_school(place / LENGTH)._replace(
        orientation=np.broadcast_to(np.float32(turns), (31, 12, 4))
    )
    (found,) = schooling(record)
    assert found.rotation == pytest.approx(1.0, abs=1e-5)
    assert found.polarisation == pytest.approx(0.0, abs=1e-5)
    assert found.states == pytest.approx([0.0, 1.0, 0.0])
    assert found.disorder == 1.0
    assert np.isnan(found.longer)


def test_proportions_are_along_the_way():
    rng = np.random.default_rng(4)
    place = rng.normal(size=(4000, 3)) * (30.0, 10.0, 5.0)
    east, north = np.tile([1.0, 0, 0], (4000, 1)), np.tile([0, 1.0, 0], (4000, 1))
    assert proportions(place, east) == pytest.approx((3.0, 6.0), rel=0.05)
    assert proportions(place, north) == pytest.approx((1 / 3, 2.0), rel=0.05)


def test_bearings_from_above_are_even_for_fishes_at_random():
    rng = np.random.default_rng(5)
    ball = rng.uniform(-8, 8, (1500, 3))
    (found,) = schooling(still_school(ball, ticks=3))
    assert found.sector.sum() == pytest.approx(1.0)
    assert found.oblique == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("bearing", "oblique"), [(45.0, True), (135.0, True), (90.0, False)])
def test_neighbours_aside_and_obliquely_are_told_apart(bearing, oblique):
    """Pairs: one fish has the nearest at that bearing, the other at its supplement."""
    angle = np.radians(bearing)
    pairs = np.array([[20.0 * k, 0.0, 0.0] for k in range(5)])
    places = np.vstack([pairs, pairs + (np.cos(angle), np.sin(angle), 0.0)])
    (found,) = schooling(still_school(places, ticks=3))
    assert len(found.sector) == SECTORS
    assert (found.oblique > 1e3) if oblique else (found.oblique == 0.0)
    assert found.near_bl == pytest.approx(1.0, rel=1e-4)


def test_a_split_may_last_from_one_part_of_a_record_to_the_next():
    """Two recorded parts, with the school in halves from the end of one into the other."""
    (whole,) = schooling(still_school(np.eye(4, 3)))
    time = np.arange(0.0, 20.0, 0.5)
    split = np.where((time >= 8.0) & (time < 13.0), 0.5, 1.0)
    parts = [
        whole._replace(time=time[part], together=split[part], calm=(time >= 11.5)[part],
                       end=float(time[part][-1]), fishes=n, polarisation=p)
        for part, n, p in ((slice(0, 20), 4, 0.9), (slice(20, 40), 5, np.nan))
    ]  # fmt: skip
    (found,) = joined(parts)
    assert found.split_s.tolist() == [5.0]
    assert found.calm_split_s.tolist() == [1.5]
    assert (found.fishes, found.polarisation) == (5, 0.9)
    assert found.states == pytest.approx(whole.states)
    assert [one.leader for one in joined([*parts, whole._replace(leader=9)])] == [whole.leader, 9]
