"""Lists of the rocks near a place, against all rocks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.vector import vector
from subsea.habitat.contact import is_free
from subsea.habitat.current import REACH_CM, flow_near
from subsea.habitat.rocks import FEW, rock_cells, rocks_near
from tests.support.seas import all_rocks

NO_PILLARS = np.zeros((0, 4))
FLOW = (3.0, -2.0, 0.0)


def _rocks(number, seed):
    rng = np.random.default_rng(seed)
    low, high = (-900, -500, -300, 20, 20, 20, 0), (700, 1100, -200, 180, 120, 90, 6.28)
    return rng.uniform(low, high, (number, 7))


@pytest.mark.parametrize("number", [0, FEW, FEW + 1, 90])
@given(seed=st.integers(0, 10**6))
def test_the_water_is_that_of_all_rocks(number, seed):
    rocks = _rocks(number, seed)
    cells = rock_cells(rocks, REACH_CM)
    for place in np.random.default_rng(seed).uniform(-1600, 1600, (50, 3)) * (1, 1, 0.2):
        p = vector(place)
        near = rocks_near(cells, p)
        there = flow_near(NO_PILLARS, all_rocks(rocks), FLOW, p)
        assert flow_near(NO_PILLARS, cells, FLOW, p) == there
        assert is_free(NO_PILLARS, near, p) == is_free(NO_PILLARS, rocks, p)


def test_few_are_listed_of_many_in_their_order():
    rocks = _rocks(400, 1)
    cells = rock_cells(rocks, 0.0)
    near = rocks_near(cells, (0.0, 0.0, -200.0))
    assert 0 < len(near) < 60
    order = [np.flatnonzero((rocks == row[:7]).all(axis=1))[0] for row in near]
    assert order == sorted(order)


def test_far_from_all_none_is_listed():
    cells = rock_cells(_rocks(90, 2), 50.0)
    for place in ((5000.0, 0.0, -200.0), (0.0, -5000.0, -200.0), (-5000.0, 5000.0, -200.0)):
        assert len(rocks_near(cells, place)) == 0
