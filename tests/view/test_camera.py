"""Cameras and rigs project points as geometry predicts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.state import Submarine
from subsea.view.camera import axes_of
from subsea.view.display_rigs import (
    DISPLAYS,
    SURROUNDS,
    VERTICAL_FOV,
    cockpit,
    display_rig,
    views_for,
)
from subsea.view.rig import pose_from_angles
from subsea.view.stereo import EYE_SEPARATION_CM, LAYOUTS, SCREEN_DISTANCE_CM, Stereo

EYE = np.array([10.0, 20.0, -300.0])


def _pixel(view, point):
    """Position of a world point in pixels from the lower left of the picture."""
    clip = view.projection.astype(float) @ view.view.astype(float) @ [*point, 1.0]
    ndc = clip[:3] / clip[3]
    x, y, w, h = view.viewport
    return np.array([x + (ndc[0] + 1) / 2 * w, y + (ndc[1] + 1) / 2 * h]), clip[3]


def test_ahead_is_the_middle_and_up_is_up():
    for heading in [0.0, 1.0, -2.5]:
        for pitch in [0.0, 0.5, -0.9]:
            observer = pose_from_angles(EYE, heading, pitch)
            (view,) = views_for("mono", (640, 360), observer)
            centre, depth = _pixel(view, EYE + 100 * observer.forward)
            np.testing.assert_allclose(centre, [320, 180], atol=1e-2)
            assert depth == pytest.approx(100, rel=1e-4)
            above, _ = _pixel(view, EYE + 100 * observer.forward + 10 * observer.up)
            assert above[1] > 180
            right, _ = _pixel(
                view, EYE + 100 * observer.forward + np.cross(observer.forward, observer.up)
            )
            assert right[0] > 320


def test_the_field_of_view_is_as_given():
    observer = pose_from_angles(EYE, 0.3, 0.0)
    (view,) = views_for("mono", (640, 360), observer)
    edge = EYE + 100 * observer.forward + 100 * np.tan(VERTICAL_FOV / 2) * observer.up
    np.testing.assert_allclose(_pixel(view, edge)[0], [320, 360], atol=0.05)


@pytest.mark.parametrize("display", ["side-by-side", "top-bottom"])
def test_the_eyes_agree_at_the_screen_and_differ_elsewhere(display):
    observer = pose_from_angles(EYE, -0.7, 0.2)
    left, right = views_for(display, (640, 360), observer)

    def parallax(distance):
        point = EYE + distance * observer.forward
        places = [(_pixel(v, point)[0] - v.viewport[:2]) / v.viewport[2:] for v in (left, right)]
        assert places[0][1] == pytest.approx(places[1][1], abs=1e-4)
        return places[1][0] - places[0][0]

    assert parallax(SCREEN_DISTANCE_CM) == pytest.approx(0, abs=1e-4)
    assert parallax(4 * SCREEN_DISTANCE_CM) > 1e-3  # behind the screen: uncrossed
    assert parallax(0.5 * SCREEN_DISTANCE_CM) < -1e-3


@given(
    point=st.tuples(st.floats(-200, 200), st.floats(-100, 100), st.floats(30, 3000)),
    separation=st.floats(0.5, 20),
    screen=st.floats(40, 2000),
    display=st.sampled_from(list(LAYOUTS)),
)
def test_a_point_lands_where_the_ray_to_each_eye_meets_the_screen(
    point, separation, screen, display
):
    """Both eyes share one screen plane: frusta are off-axis, never toed in."""
    observer, size = pose_from_angles(EYE, 0.4, -0.3), (640, 360)
    stereo = Stereo(separation_cm=separation, screen_cm=screen)
    side = np.cross(observer.forward, observer.up)
    axes = np.stack([side, observer.up, observer.forward])
    half_height = screen * np.tan(VERTICAL_FOV / 2)
    half = np.array([half_height * size[0] / size[1], half_height])
    views = views_for(display, size, observer, stereo)
    for view, offset in zip(views, (-separation / 2, separation / 2), strict=True):
        place, depth = _pixel(view, EYE + np.array(point) @ axes)
        assert depth == pytest.approx(point[2], rel=1e-3)
        x, y, w, h = view.viewport
        eye = np.array([offset, 0.0])
        met = eye + (np.array(point[:2]) - eye) * screen / point[2]  # on the screen, cm
        expected = np.array([x, y]) + (met / half + 1) / 2 * [w, h]
        np.testing.assert_allclose(place, expected, rtol=2e-4, atol=0.1)


def test_swapped_eyes_exchange_their_pictures():
    observer = pose_from_angles(EYE, 0.0, 0.0)
    left, right = views_for("anaglyph", (64, 36), observer)
    other_left, other_right = views_for("anaglyph", (64, 36), observer, Stereo(swapped=True))
    np.testing.assert_array_equal(other_left.view, right.view)
    np.testing.assert_array_equal(other_right.projection, left.projection)
    assert other_left.viewport == left.viewport


@given(width=st.floats(20, 3000), separation=st.floats(1, 60))
def test_on_no_screen_do_the_eyes_have_to_turn_outwards(width, separation):
    """Parallax of infinity, in real centimetres between the positions in both eyes."""
    stereo = Stereo(separation_cm=separation, screen_width_cm=width)
    observer, size = pose_from_angles(EYE, 0.0, 0.0), (640, 360)
    places = [
        _pixel(view, EYE + 1e6 * observer.forward)[0][0] / size[0]
        for view in views_for("anaglyph", size, observer, stereo)
    ]
    apart = (places[1] - places[0]) * width
    window = 2 * stereo.screen_cm * np.tan(VERTICAL_FOV / 2) * size[0] / size[1]
    assert apart == pytest.approx(min(EYE_SEPARATION_CM, separation * width / window), rel=0.01)


@given(comfort=st.floats(0.2, 5), separation=st.floats(1, 20), screen=st.floats(40, 500))
def test_comfort_limits_how_far_eyes_turn_from_the_screen(comfort, separation, screen):
    """Vergence between the screen and infinity, and between half its distance and itself."""
    stereo = Stereo(separation_cm=separation, screen_cm=screen, comfort_deg=comfort)
    apart = stereo.eyes(300.0)
    for near, far in ((screen, np.inf), (screen / 2, screen)):
        turned = np.degrees(apart / near - apart / far)
        assert turned <= comfort * (1 + 1e-9)
    unlimited = np.degrees(separation / screen)
    assert apart == pytest.approx(separation * min(1, comfort / unlimited))


def test_viewports_tile_the_canvas():
    for display in [name for name in DISPLAYS if name not in SURROUNDS]:
        for size in [(640, 360), (641, 361)]:
            views = views_for(display, size, pose_from_angles(EYE, 0.0, 0.0))
            covered = np.zeros(display_rig(display, size).canvas, int)
            for x, y, w, h in (v.viewport for v in views):
                covered[x : x + w, y : y + h] += 1
            assert (covered == 1).all()


def test_the_cockpit_is_between_the_last_two_ticks_the_short_way_round():
    submarine = Submarine(position=np.array([10.0, 0.0, -100.0]))
    submarine.angles[:] = -3.1, 0.2
    submarine.previous_angles[:] = 3.1, 0.0
    half = cockpit(submarine, 0.5)
    np.testing.assert_allclose(half.forward[:2] / np.cos(0.1), [-1.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(half.forward[2], np.sin(0.1), atol=1e-9)
    np.testing.assert_allclose(half.eye - 20 * half.forward, [5.0, 0.0, -50.0], atol=1e-9)


@given(heading=st.floats(-7, 7), pitch=st.floats(-7, 7), roll=st.floats(-7, 7))
def test_axes_turn_to_the_right_then_up_then_clockwise(heading, pitch, roll):
    right, up, ahead = axes = axes_of(heading, pitch, roll)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(ahead, right), up, atol=1e-12)
    ch, sh, cp, sp = np.cos(heading), np.sin(heading), np.cos(pitch), np.sin(pitch)
    cr, sr = np.cos(roll), np.sin(roll)
    yaw = np.array([[ch, 0, sh], [0, 1, 0], [-sh, 0, ch]])  # ahead comes to the right
    rise = np.array([[1, 0, 0], [0, cp, sp], [0, -sp, cp]])  # ahead comes up
    clockwise = np.array([[cr, sr, 0], [-sr, cr, 0], [0, 0, 1]])  # up comes to the right
    np.testing.assert_allclose(axes, (yaw @ rise @ clockwise).T, atol=1e-12)
