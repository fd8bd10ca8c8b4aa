"""Rays from the screen into the sea, and back."""

import numpy as np

from subsea.view.display_rigs import display_rig
from subsea.view.front_screen import front_screen
from subsea.view.rig import pose_from_angles, views

SIZE = (640, 400)
FLAT = ("mono", "side-by-side", "top-bottom", "anaglyph", "interlaced")


def test_a_ray_meets_what_is_seen_at_its_place():
    for display in FLAT:
        rng = np.random.default_rng(1)
        rig = display_rig(display, SIZE)
        seen = front_screen(
            rig, views(rig, pose_from_angles(np.array([10.0, 20.0, -300.0]), 0.7, -0.3))
        )
        for x, y in rng.uniform(0.0, 1.0, (20, 2)):
            eye, way = seen.ray(x, y)
            points = eye + np.outer([30.0, 400.0], way)
            np.testing.assert_allclose(seen.places(points), [(x, y)] * 2, atol=1e-4)


def test_the_middle_is_straight_ahead_and_the_upper_left_corner_left_and_above():
    rig = display_rig("mono", SIZE)
    seen = front_screen(rig, views(rig, pose_from_angles(np.zeros(3), 0.0, 0.0)))
    np.testing.assert_allclose(seen.ray(0.5, 0.5)[1], (1.0, 0.0, 0.0), atol=1e-6)
    _, corner = seen.ray(0.0, 0.0)
    assert corner[1] > 0.2 and corner[2] > 0.1


def test_points_behind_the_eye_have_no_place():
    rig = display_rig("mono", SIZE)
    seen = front_screen(rig, views(rig, pose_from_angles(np.zeros(3), 0.0, 0.0)))
    assert np.isnan(seen.places(np.array([[-50.0, 0.0, 0.0]]))).all()


def test_there_is_none_where_the_picture_is_not_flat():
    for display in ["panorama", "dome", "equirectangular"]:
        rig = display_rig(display, SIZE)
        assert front_screen(rig, views(rig, pose_from_angles(np.zeros(3), 0.0, 0.0))) is None
