"""Places on the panel before an observer, and rays to it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.view.theatre_vessel import PANEL

SHARE = st.floats(0.0, 1.0)


@given(SHARE, SHARE)
def test_a_ray_through_a_place_hits_it(x, y):
    (place,) = PANEL.places(np.array([x]), np.array([y]))
    start = np.array([20.0, -30.0, 10.0])
    assert (
        PANEL.hit(start, place - start) == pytest.approx((x, y), abs=1e-6)
        or min(x, 1 - x, y, 1 - y) < 1e-6
    )


def test_rays_beside_along_and_away_from_it_hit_nothing():
    start = np.zeros(3)
    assert PANEL.hit(start, np.array([0.0, 0.0, -1.0])) is None
    assert PANEL.hit(start, np.array([1.0, 0.0, 0.5])) is None
    assert PANEL.hit(start, np.array([1.0, 0.0, 0.0])) is None


def test_its_upper_left_corner_is_left_and_above():
    corner, other = PANEL.places(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    assert corner[0] < other[0] and corner[1] > other[1]
