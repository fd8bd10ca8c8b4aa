"""The test pattern lies where patches take something from, and says which they are."""

import numpy as np
import pytest

from subsea.view.display_rigs import display_rig
from subsea.view.rig import DisplayPatch
from subsea.view.surround import MARGIN_PX
from subsea.view.test_pattern import lineup, pattern

SIZE = (160, 120)


def test_one_eye_has_the_pattern_of_channel_one():
    np.testing.assert_array_equal(lineup(display_rig("mono", SIZE)), pattern(SIZE, 1))


@pytest.mark.parametrize("display", ["stereo", "anaglyph", "checkerboard"])
def test_each_eye_has_its_letter(display):
    left, right = np.split(lineup(display_rig(display, SIZE)), 2)
    np.testing.assert_array_equal(left, pattern(SIZE, 1, "L"))
    np.testing.assert_array_equal(right, pattern(SIZE, 1, "R"))
    assert (left != right).any()


def test_channels_are_numbered():
    rig = display_rig("mono", SIZE)
    halves = [
        DisplayPatch(part, part, part, channel=k)
        for k, part in enumerate([(0, 0, 80, 120), (80, 0, 80, 120)])
    ]
    canvas = lineup(rig._replace(patches=tuple(halves)))
    np.testing.assert_array_equal(canvas[:, :80], pattern((80, 120), 1))
    np.testing.assert_array_equal(canvas[:, 80:], pattern((80, 120), 2))
    assert (canvas[:, :80] != canvas[:, 80:]).any()


def test_the_faces_of_a_cube_say_where_they_look():
    canvas = lineup(display_rig("dome", SIZE))
    high, wide = canvas.shape[0] // 2, canvas.shape[1] // 3
    inner = (wide - 2 * MARGIN_PX, high - 2 * MARGIN_PX)
    lower = canvas[high + MARGIN_PX : -MARGIN_PX, wide + MARGIN_PX : 2 * wide - MARGIN_PX]
    np.testing.assert_array_equal(lower, pattern(inner, 1, "ahead"))
    upper = canvas[MARGIN_PX : high - MARGIN_PX, 2 * wide + MARGIN_PX : -MARGIN_PX]
    np.testing.assert_array_equal(upper, pattern(inner, 1, "above"))
