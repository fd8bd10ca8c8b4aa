"""Test patterns: what a person at the screen has to see in them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.view.test_pattern import colour_of, pattern

SIZE = (400, 300)
MIDDLE = (slice(90, 190), slice(130, 270))  # where the number is


@given(st.integers(1, 999), st.text(max_size=30), st.integers(1, 300), st.integers(1, 300))
def test_any_channel_has_a_pattern_whose_outermost_pixels_are_lit(number, word, width, height):
    picture = pattern((width, height), number, word)
    assert (picture.shape, picture.dtype) == ((height, width, 3), np.uint8)
    for edge in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert (edge == 255).all()


def test_numbers_names_and_colours_differ():
    pictures = [pattern(SIZE, number, "a") for number in range(1, 13)]
    grey = [picture[MIDDLE].max(axis=2) > 200 for picture in pictures]
    for k, one in enumerate(grey):
        assert one.sum() > 300
        assert all((one != other).sum() > 100 for other in grey[:k])
    other = pattern(SIZE, 1, "b")
    assert (other != pictures[0]).any()
    colours = np.array([colour_of(number) for number in range(1, 9)], float)
    apart = np.linalg.norm(colours[:, None] - colours[None], axis=2) + 1e3 * np.eye(8)
    assert apart.min() > 50


@pytest.mark.parametrize("size", [(400, 300), (300, 400), (900, 300)])
def test_the_circle_is_round(size):
    picture = pattern(size, 3, "")
    middle = (np.array(size) - 1) / 2
    rows, columns = np.nonzero((picture == colour_of(3)).all(axis=2))
    away = np.hypot(columns - middle[0], rows - middle[1]) / (min(size) / 100)
    on = np.abs(away - 45) < 2.5
    turn = np.arctan2(rows[on] - middle[1], columns[on] - middle[0])
    assert (np.histogram(turn, 24, (-np.pi, np.pi))[0] > 0).sum() >= 22  # the ramp covers a part
    assert np.ptp(away[on]) < 3


def test_lines_lie_at_each_tenth():
    row = pattern((401, 301), 1, "")[10].max(axis=1)
    bright = np.nonzero(row > 120)[0]
    np.testing.assert_array_equal(bright[(bright > 60) & (bright < 340)], np.arange(80, 330, 40))


def test_the_ramp_runs_from_black_to_white_in_even_steps():
    picture = pattern((1100, 1000), 1, "")
    steps = picture[815, 220 + 30 : 880 : 60, 0].astype(int)
    np.testing.assert_allclose(steps, np.linspace(0, 255, 11), atol=1)
    smooth = picture[845, 220:880, 0].astype(int)
    assert (smooth[0], smooth[-1]) == (0, 255)
    assert np.diff(smooth).min() >= 0
    assert np.diff(smooth).max() <= 1
