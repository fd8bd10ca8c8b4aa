"""Choice of the front patch, and parts of a rig."""

import numpy as np
import pytest

from subsea.view.camera import off_axis
from subsea.view.display_rigs import DISPLAYS, display_rig
from subsea.view.rig import (
    CameraRig,
    DisplayPatch,
    Eye,
    Projection,
    front,
    limit_separation,
    pose_from_angles,
    seen_by,
    seen_part,
    select_outputs,
    tile,
    views,
)
from subsea.view.stereo import LAYOUTS
from subsea.view.surround import ALL_ROUND, directions


def turned(degrees):
    """Axes of an eye that is turned right."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def row(*degrees):
    """A rig of square windows, each with a view turned by an angle."""
    eyes, patches = [], []
    for k, angle in enumerate(degrees):
        part = (10 * k, 0, 10, 10)
        eyes.append(Eye(part, np.zeros(3), turned(angle), off_axis(-1.0, 1.0, -1.0, 1.0)))
        patches.append(DisplayPatch((0, 0, 10, 10), part, part, output=k, channel=k))
    n = len(degrees)
    return CameraRig((10 * n, 10), ((10, 10),) * n, tuple(eyes), tuple(patches))


def test_the_front_is_what_is_most_straight_ahead():
    for degrees, number in [((-60, 0, 60), 1), ((0, 90), 0), ((-90, 180, 20), 2), ((-30, 30), 0)]:
        assert front(row(*degrees)).output == number


def test_a_frustum_that_leans_aside_is_not_the_front():
    rig = row(0, 0)
    leaning = rig.eyes[0]._replace(projection=off_axis(1.0, 3.0, -1.0, 1.0))
    assert front(rig._replace(eyes=(leaning, rig.eyes[1]))).output == 1


def test_every_display_has_a_front():
    for display in DISPLAYS:
        assert front(display_rig(display, (64, 48))).output == 0


def test_a_part_has_its_outputs_and_only_the_eyes_that_they_need():
    rig = row(-60, 0, 60)
    part = select_outputs(rig, [2, 1])
    assert [patch.output for patch in part.patches] == [1, 0]
    assert [patch.channel for patch in part.patches] == [1, 2]
    assert part.eyes == (rig.eyes[1], rig.eyes[2])
    assert len(part.outputs) == 2
    for patch in part.patches:
        assert seen_by(part, patch)[0].viewport == patch.left


def test_the_whole_is_a_part():
    for display in DISPLAYS:
        rig = display_rig(display, (64, 48))
        assert select_outputs(rig, [0]) == rig


def test_of_a_dome_all_is_seen_in_the_square_within_its_circle():
    for size in [(800, 600), (600, 800), (501, 499)]:
        for squeezed in [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0)]:
            (patch,) = display_rig("dome", size).patches
            assert seen_part(patch._replace(shape=Projection.PANORAMA)) == patch.place
            across, up = (int(n / by) for n, by in zip(size, squeezed, strict=True))
            x, y, width, height = seen_part(
                patch._replace(place=(7, 9, across, up), squeezed=squeezed)
            )
            corners = np.array([(a, b) for a in (x, x + width) for b in (y, y + height)], float)
            off = (corners - [7, 9]) * squeezed - np.array(size) / 2  # from the middle
            radius = min(size) / 2
            np.testing.assert_allclose(np.linalg.norm(off, axis=1), radius, atol=3.0)
            shown = directions("dome", size, ALL_ROUND, np.array(size) / 2 + 0.98 * off)
            assert not np.isnan(shown).any()


def masked(factors, added=0.0, place=(10, 20, 400, 300)):
    """A patch whose mask has these factors (h, w), top row first."""
    mask = np.repeat(np.asarray(factors, np.float32)[..., None], 4, axis=2)
    mask[..., 3] = added
    return DisplayPatch(place, place, place, mask=mask)


def test_a_patch_without_blending_is_clear():
    assert seen_part(masked(np.ones((30, 40)))) == (10, 20, 400, 300)
    assert seen_part(masked(np.full((30, 40), 0.5), 0.2)) == (10, 20, 400, 300)
    assert seen_part(masked(np.ones((3, 4)))._replace(mask=None)) == (10, 20, 400, 300)


def test_a_patch_is_clear_between_its_blends():
    factors = np.ones((30, 40))
    factors[:, :4] *= np.linspace(0.1, 0.9, 4)
    factors[:, -8:] *= np.linspace(0.9, 0.1, 8)
    factors[:6] *= 0.5  # the upper rows
    assert seen_part(masked(factors)) == (10 + 40, 20, 280, 240)


def test_no_clear_pixel_is_blended():
    for size in [(7, 5), (90, 62), (1440, 1000)]:
        s, t = (np.arange(n) / n for n in size)
        hill = np.minimum.outer(1.0 - (2 * t - 1.1) ** 6, 1.0 - (2 * s - 0.9) ** 8)
        place = (10, 20, 360, 250)
        x, y, width, height = seen_part(masked(hill, place=place))
        assert width > 120
        assert height > 84
        columns = (np.arange(x - 10, x - 10 + width) + 0.5) / 360 * size[0]
        rows = (np.arange(270 - y - height, 270 - y) + 0.5) / 250 * size[1]
        inside = hill[np.ix_(rows.astype(int), columns.astype(int))]
        assert inside.min() > 0.94  # a step between two sampled values


def test_where_all_is_blended_no_part_is_better():
    factors = np.full((30, 40), 0.6)
    factors[12:15, 10:14] = 1.0
    assert seen_part(masked(factors)) == (10, 20, 400, 300)


def seen_apart(rig, distance):
    """Disparity of both eyes at a distance ahead, in halves of the picture."""
    places = []
    for view in views(rig, pose_from_angles(np.zeros(3), 0.0, 0.0))[:2]:
        x, _, _, w = view.projection @ view.view @ (distance, 0.0, 0.0, 1.0)
        places.append(x / w)
    return places[0] - places[1]


def test_a_fish_sees_near_things_as_a_person_sees_far_ones():
    for display in LAYOUTS:
        rig = display_rig(display, (64, 48))
        near = limit_separation(rig, 0.32)  # a tenth of a person's
        assert np.linalg.norm(near.eyes[0].offset - near.eyes[1].offset) == pytest.approx(0.64)
        for distance in (60.0, 120.0, 1000.0):
            assert seen_apart(near, distance / 10) == pytest.approx(
                seen_apart(rig, distance), abs=1e-6
            )
        assert abs(seen_apart(near, 12.0)) < 1e-6 < seen_apart(near, 6.0) < seen_apart(rig, 6.0) / 9


def test_eyes_that_are_near_enough_stay():
    for display in ("mono", "side-by-side"):
        rig = display_rig(display, (64, 48))
        assert limit_separation(rig, 3.3) is rig


@pytest.mark.parametrize("display", DISPLAYS)
def test_eyes_tile_the_canvas_but_for_the_faces_of_a_cube_that_are_seen_in_part(display):
    rig = display_rig(display, (320, 180))
    whole = tile([eye.viewport for eye in rig.eyes], rig.canvas)
    assert whole == (display not in ("panorama", "dome"))


def test_parts_with_a_gap_or_an_overlap_do_not_tile_a_picture():
    size = 40, 30
    assert tile([(0, 0, 25, 30), (25, 0, 15, 30)], size)
    assert not tile([(0, 0, 25, 30), (26, 0, 14, 30)], size)
    assert not tile([(0, 0, 25, 30), (20, 0, 15, 30)], size)  # as large together as the picture
