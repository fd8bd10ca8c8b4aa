"""Surround displays: directions of the pixels of wide pictures."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.view.display_rigs import display_rig, views_for
from subsea.view.rig import pose_from_angles, views
from subsea.view.surround import ALL_ROUND, MARGIN_PX, Surround, directions, face_size

SIZES = {"equirectangular": (400, 200), "dome": (300, 300), "panorama": (400, 100)}
EYE = np.array([10.0, 20.0, -300.0])


def look_at(display, *pixels, surround=ALL_ROUND):
    return directions(display, SIZES[display], surround, np.array(pixels, float))


def test_an_equirectangular_picture_has_the_front_in_its_middle_and_the_zenith_on_top():
    ahead, right, above, astern = look_at(
        "equirectangular", (200, 100), (300, 100), (200, 200), (0, 100)
    )
    np.testing.assert_allclose(ahead, [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(right, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(above, [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(astern, [0, 0, -1], atol=1e-12)


def test_a_dome_is_equidistant_from_its_middle_and_has_the_front_below():
    for tilt in [0.0, 30.0, 90.0]:
        surround = Surround(tilt_deg=tilt)
        pixels = np.random.default_rng(1).uniform(0, 300, (200, 2))
        found = look_at("dome", *pixels, surround=surround)
        middle = [0.0, np.cos(np.radians(tilt)), np.sin(np.radians(tilt))]
        away = np.linalg.norm(pixels - 150, axis=1) / 150
        inside = away <= 1
        np.testing.assert_allclose(
            np.degrees(np.arccos(found[inside] @ middle)), 90 * away[inside], atol=1e-6
        )
        assert np.isnan(found[~inside]).all()
        below, right = look_at("dome", (150, 1e-9), (300 - 1e-9, 150), surround=surround)
        np.testing.assert_allclose(below, [0, -np.sin(np.radians(tilt)), np.cos(np.radians(tilt))],
                                   atol=1e-6)  # fmt: skip
        np.testing.assert_allclose(right, [1, 0, 0], atol=1e-6)


@given(angle=st.floats(30, 359))
def test_a_panorama_spans_its_angle_and_has_square_pixels_at_the_horizon(angle):
    surround = Surround(angle_deg=angle)
    left, right, middle, above = look_at(
        "panorama", (0, 50), (400, 50), (200, 50), (200, 51), surround=surround
    )
    bearing = np.degrees(np.arctan2([left[0], right[0]], [left[2], right[2]]))
    np.testing.assert_allclose((bearing + 540) % 360 - 180, [-angle / 2, angle / 2], atol=1e-6)
    np.testing.assert_allclose(middle, [0, 0, 1], atol=1e-12)
    assert above[1] / above[2] == pytest.approx(np.radians(angle) / 400)


def test_faces_lie_apart_and_hold_all_that_the_picture_shows():
    """A direction is inside one face, or near the edge of two or three."""
    for display in SIZES:
        for surround in [ALL_ROUND, Surround(angle_deg=60.0, tilt_deg=0.0)]:
            size, observer = SIZES[display], pose_from_angles(EYE, 0.7, 0.0)
            rig = display_rig(display, size, surround=surround)
            face = face_size(display, size, surround)
            covered = np.zeros(rig.canvas, int)
            for x, y, w, h in (eye.viewport for eye in rig.eyes):
                assert x // face == (x + w - 1) // face
                assert y // face == (y + h - 1) // face
                covered[x : x + w, y : y + h] += 1
            assert covered.max() == 1
            pixels = np.random.default_rng(2).uniform(0, 1, (2000, 2)) * size
            d = directions(display, size, surround, pixels)
            d = d[~np.isnan(d[:, 0])]
            axes = np.stack(
                [np.cross(observer.forward, observer.up), observer.up, observer.forward]
            )
            seen = np.zeros(len(d), int)
            for view in views(rig, observer):
                points = np.column_stack([EYE + 100.0 * d @ axes, np.ones(len(d))])
                clip = points @ (view.projection @ view.view).T
                inside = (clip[:, 3] > 0) & (np.abs(clip[:, :2]) <= clip[:, 3:]).all(axis=1)
                seen += inside
            assert seen.min() == 1
            assert (seen > 1).mean() < 12 * MARGIN_PX / face


def test_parts_outside_of_the_picture_are_not_drawn():
    drawn = {
        display: sum(eye.viewport[2] * eye.viewport[3] for eye in rig.eyes) / np.prod(rig.canvas)
        for display, rig in ((name, display_rig(name, (800, 200))) for name in SIZES)
    }
    assert drawn["equirectangular"] == 1.0
    assert drawn["dome"] < 0.75  # half of all directions, the margins, and corners of faces
    assert drawn["panorama"] < 0.3
    astern = [eye for eye in display_rig("panorama", (800, 200)).eyes if eye.axes[2, 2] < -0.5]
    assert not astern


def test_only_pictures_of_all_directions_keep_the_horizon_level():
    for display, level in [("equirectangular", True), ("panorama", False)]:
        pitched = views_for(display, SIZES[display], pose_from_angles(EYE, 0.7, 0.4))
        upright = views_for(display, SIZES[display], pose_from_angles(EYE, 0.7, 0.0))
        same = all(np.allclose(a.view, b.view) for a, b in zip(pitched, upright, strict=True))
        assert same == level
