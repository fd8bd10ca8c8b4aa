"""Distances from pillars and rocks, against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.habitat.solids import clearance, from_pillar, from_rock, is_free

PILLAR = np.array([30.0, -20.0, 50.0, -100.0])
ROCK = np.array([10.0, 20.0, -250.0, 80.0, 40.0, 30.0, 0.7])
PLACE = st.tuples(st.floats(-300, 300), st.floats(-300, 300), st.floats(-300, 0))


@pytest.mark.parametrize(
    ("place", "way", "distance"),
    [
        ((130.0, -20.0, -200.0), (1, 0, 0), 50.0),
        ((30.0, -120.0, -200.0), (0, -1, 0), 50.0),
        ((30.0, -20.0, -60.0), (0, 0, 1), 40.0),
        ((110.0, -20.0, -60.0), (0.6, 0, 0.8), 50.0),
        ((70.0, -20.0, -200.0), (1, 0, 0), -10.0),
        ((35.0, -20.0, -103.0), (0, 0, 1), -3.0),
    ],
)
def test_off_a_pillar(place, way, distance):
    got_way, got = from_pillar(PILLAR, place)
    assert got_way == pytest.approx(way, abs=1e-9)
    assert got == pytest.approx(distance)


@given(PLACE)
def test_a_step_off_a_pillar_changes_the_distance_by_as_much(place):
    way, distance = from_pillar(PILLAR, place)
    assert np.linalg.norm(way) == pytest.approx(1.0)
    there = tuple(np.add(place, np.multiply(7.0, way)))
    if distance > 0:
        assert from_pillar(PILLAR, there)[1] == pytest.approx(distance + 7.0, abs=1e-6)


def test_off_a_round_rock_the_distance_is_exact():
    ball = np.array([10.0, 20.0, -250.0, 40.0, 40.0, 40.0, 0.3])
    for x, distance in ((90.0, 40.0), (50.0, 0.0), (30.0, -20.0)):
        way, got = from_rock(ball, (x, 20.0, -250.0))
        assert way == pytest.approx((1, 0, 0), abs=1e-12)
        assert got == pytest.approx(distance, abs=1e-9)


@given(st.floats(0, 6.28), st.floats(-1.5, 1.5))
def test_a_rock_is_the_ellipsoid_that_is_asked_for(longitude, latitude):
    a, b, c = ROCK[3:6]
    x, y, z = (
        a * np.cos(latitude) * np.cos(longitude),
        b * np.cos(latitude) * np.sin(longitude),
        c * np.sin(latitude),
    )
    turned = (np.cos(0.7) * x - np.sin(0.7) * y, np.sin(0.7) * x + np.cos(0.7) * y, z)
    place = np.add(ROCK[:3], turned)
    way, distance = from_rock(ROCK, tuple(place))
    assert distance == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(way) == pytest.approx(1.0)
    # One centimetre along the way and back.
    assert from_rock(ROCK, tuple(place + way))[1] == pytest.approx(1.0, abs=0.05)
    assert from_rock(ROCK, tuple(place - np.array(way)))[1] == pytest.approx(-1.0, abs=0.05)


def test_the_middle_of_a_rock_is_deep_in_it():
    assert from_rock(ROCK, tuple(ROCK[:3]))[1] == -30.0


@given(PLACE)
def test_free_is_where_there_is_clearance(place):
    pillars, rocks = PILLAR[None], ROCK[None]
    nearest = clearance(pillars, rocks, place)
    assert nearest == min(from_pillar(PILLAR, place)[1], from_rock(ROCK, place)[1])
    assert is_free(pillars, rocks, place) == (nearest >= 0.0)
