"""Free places beside pillars and rocks, and the way out of them."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from subsea.geometry.solids import from_pillar, from_rock
from subsea.habitat.contact import clearance, clearances, is_free, out_of_solids

PILLAR = np.array([30.0, -20.0, 50.0, -100.0])
ROCK = np.array([10.0, 20.0, -250.0, 80.0, 40.0, 30.0, 0.7])
PLACE = st.tuples(st.floats(-300, 300), st.floats(-300, 300), st.floats(-300, 0))


@given(PLACE)
def test_free_is_where_there_is_clearance(place):
    pillars, rocks = PILLAR[None], ROCK[None]
    nearest = clearance(pillars, rocks, place)
    assert nearest == min(from_pillar(PILLAR, place)[1], from_rock(ROCK, place)[1])
    assert is_free(pillars, rocks, place) == (nearest >= 0.0)


def test_many_places_at_once():
    places = np.random.default_rng(0).uniform(-200, 0, (50, 3))
    each = [clearance(PILLAR[None], ROCK[None], tuple(map(float, p))) for p in places]
    np.testing.assert_allclose(clearances(PILLAR[None], ROCK[None], places), each)


@given(PLACE)
@example((0.0, 74.0, -262.0))  # free, but too low, and too near the rock once it is raised
def test_the_way_out_ends_in_free_water(make_sea, place):
    """Out of a pillar that pierces the surface too, where it and a rock overlap."""
    pillars = np.array([PILLAR, (-120.0, 0.0, 60.0, 50.0)])
    sea = make_sea(pillars=pillars, rocks=[ROCK])
    there = out_of_solids(sea, place, 12.0, 40.0, 40.0)
    assert clearance(sea.pillars, sea.rocks, there) >= 12.0 - 1e-6
    assert -300.0 + 40.0 <= there[2] <= -40.0
    if clearance(sea.pillars, sea.rocks, place) >= 12.0 and -260.0 <= place[2] <= -40.0:
        assert there == place
