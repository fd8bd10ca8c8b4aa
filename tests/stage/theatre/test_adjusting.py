"""Adjustments in theatre files: what they do to the rig, and bad ones in one line."""

import re

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.setup import set_up_theatre, shrink_theatre
from subsea.stage.theatre.adjusting import (
    in_larger_pixels,
    moved_places,
    patch_adjustment,
    tidy,
    upright,
)
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_file import Adjustment, Corners

SIZE = (400, 200)
THEATRE = """
[[window]]
name = "left"
size = [400, 200]

[[window]]
name = "right"
size = [400, 200]

[[channel]]
name = "left"
window = "left"
angles = {{ left_deg = -32, right_deg = 4, down_deg = -11, up_deg = 11 }}
{left}

[[channel]]
name = "right"
window = "right"
angles = {{ left_deg = -4, right_deg = 32, down_deg = -11, up_deg = 11 }}
"""


@pytest.fixture
def written(tmp_path):
    """Keys of the left channel -> the theatre's file."""

    def written(left=""):
        path = tmp_path / "foyer.toml"
        path.write_text(THEATRE.format(left=left))
        return path

    return written


def test_a_picture_as_it_is_has_no_adjustment(written):
    assert patch_adjustment(Adjustment(), SIZE) is None
    assert (
        patch_adjustment(Adjustment(corners_px=Corners(), points_px=[[(0, 0)] * 3] * 2), SIZE)
        is None
    )
    rig = set_up_theatre(str(written())).rig
    assert all(patch.adjustment is None for patch in rig.patches)


def test_keys_reach_the_patches_of_their_channel(written):
    path = written("corners_px = { upper_left = [4, 2] }\ngain = [1, 0.5, 0.25]\ngamma = 2.4")
    left, right = set_up_theatre(str(path)).rig.patches
    assert right.adjustment is None
    assert left.gamma == 2.4
    assert left.adjustment.gain == (1.0, 0.5, 0.25)
    [place] = moved_places(Adjustment(corners_px=Corners(upper_left=(4, 2))), SIZE, [[0.0, 1.0]])
    assert place == pytest.approx([4 / 400, 1.0 - 2 / 200])


def test_points_count_from_above(written):
    points = [[(0.0, 0.0)] * 2, [(0.0, 0.0), (8.0, 4.0)]]
    places = moved_places(Adjustment(points_px=points), SIZE, [[1.0, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose(places, [[1.0 + 8 / 400, -4 / 200], [1.0, 1.0]])


def test_a_picture_on_its_side_is_drawn_with_its_own_sides(written):
    assert upright(Adjustment(rotate=270), SIZE) == (200, 400)
    setup = set_up_theatre(str(written("rotate = 90")))
    left, right = setup.rig.patches
    assert left.left[2:] == (200, 400) and right.left[2:] == (400, 200)
    assert left.place[2:] == (400, 200)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("corners_px = { upper_left = [300, 150], lower_right = [-300, 0] }",
         r"toml:10: channel 'left': `corners_px`: the moved corners cross, expected a convex"),
        ("points_px = [[[0, 0], [0, 0]], [[0, 0]]]", r"at least 2"),
        ("points_px = [[[0, 0], [0, 0], [0, 0]], [[0, 0], [0, 0]]]",
         "`points_px`: its rows have different lengths"),
        ("points_px = [[[0, 0], [0, 0]], [[500, 0], [-500, 0]]]", "`points_px`: .* fold"),
        ("edge_mask = [[0, 0], [1, 1]]", "at least 3"),
        ("rotate = 45", "rotate"),
        ('flip = "sideways"', "flip"),
        ("gain = [1, 1, 1.5]", "at most 1"),
        ("blend_width = 0", r"at least 0\.1"),
        ("corners_px = { top = [1, 1] }", "unknown key"),
    ],
)  # fmt: skip
def test_bad_adjustments_are_one_line_with_the_key(written, keys, said):
    path = written(keys)
    try:
        faults = usable_channels(*load_theatre(str(path)))[1]
    except UserError as fault:
        faults = [fault]
    [fault] = faults
    line = str(fault)
    assert "\n" not in line and str(path) in line
    assert re.search(said, line), line


def test_a_shrunk_theatre_has_the_same_shares(written):
    keys = "corners_px = { upper_left = [4, 2] }\nedge_mask = [[0, 0], [400, 0], [0, 200]]"
    whole = load_theatre(str(written(keys)))[0]
    small = shrink_theatre(whole, 2)
    one, other = (patch_adjustment(t.channel[0], t.window[0].size) for t in (whole, small))
    np.testing.assert_allclose(one.corners, other.corners)
    np.testing.assert_allclose(one.edge, other.edge)
    assert in_larger_pixels(whole.channel[0], 1) is whole.channel[0]


def test_what_is_not_moved_is_left_out():
    moved = Adjustment(corners_px=Corners(), points_px=[[(0.0, 0.0)] * 2] * 2, gamma=2.0)
    assert tidy(moved) == Adjustment(gamma=2.0)
    kept = msgspec.structs.replace(moved, corners_px=Corners(upper_left=(0.0, 0.1)))
    assert tidy(kept).corners_px == kept.corners_px
