"""Bilinear heights."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.solids import height_at

inside = st.floats(-50, 50)


@given(inside, inside)
def test_a_plane_is_reproduced(x, y):
    axis = np.linspace(-50, 50, 11)
    X, Y = np.meshgrid(axis, axis)
    heights = (2 * X - 3 * Y + 5).astype(np.float32)
    assert abs(height_at(heights, 50.0, x, y) - (2 * x - 3 * y + 5)) < 1e-9


@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))
def test_never_beyond_the_lowest_and_highest(x, y):
    heights = np.random.default_rng(3).normal(size=(7, 7)).astype(np.float32)
    h = height_at(heights, 50.0, x, y)
    assert heights.min() - 1e-9 <= h <= heights.max() + 1e-9
