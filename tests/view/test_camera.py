"""Cameras and rigs: points land where geometry says."""

import numpy as np
import pytest

from subsea.state import Submarine
from subsea.view.rigs import DISPLAYS, SCREEN_DISTANCE_CM, VERTICAL_FOV, cockpit, pose, views_for

EYE = np.array([10.0, 20.0, -300.0])


def _pixel(view, point):
    """Where a world point lands, in pixels from the lower left of the picture."""
    clip = view.projection.astype(float) @ view.view.astype(float) @ [*point, 1.0]
    ndc = clip[:3] / clip[3]
    x, y, w, h = view.viewport
    return np.array([x + (ndc[0] + 1) / 2 * w, y + (ndc[1] + 1) / 2 * h]), clip[3]


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("pitch", [0.0, 0.5, -0.9])
def test_ahead_is_the_middle_and_up_is_up(heading, pitch):
    observer = pose(EYE, heading, pitch)
    (view,) = views_for("mono", (640, 360), observer)
    centre, depth = _pixel(view, EYE + 100 * observer.forward)
    np.testing.assert_allclose(centre, [320, 180], atol=1e-2)
    assert depth == pytest.approx(100, rel=1e-4)
    above, _ = _pixel(view, EYE + 100 * observer.forward + 10 * observer.up)
    assert above[1] > 180
    right, _ = _pixel(view, EYE + 100 * observer.forward + np.cross(observer.forward, observer.up))
    assert right[0] > 320


def test_the_field_of_view_is_what_it_says():
    observer = pose(EYE, 0.3, 0.0)
    (view,) = views_for("mono", (640, 360), observer)
    edge = EYE + 100 * observer.forward + 100 * np.tan(VERTICAL_FOV / 2) * observer.up
    np.testing.assert_allclose(_pixel(view, edge)[0], [320, 360], atol=0.05)


@pytest.mark.parametrize("display", ["side-by-side", "top-bottom"])
def test_the_eyes_agree_at_the_screen_and_differ_elsewhere(display):
    observer = pose(EYE, -0.7, 0.2)
    left, right = views_for(display, (640, 360), observer)

    def parallax(distance):
        point = EYE + distance * observer.forward
        places = [(_pixel(v, point)[0] - v.viewport[:2]) / v.viewport[2:] for v in (left, right)]
        assert places[0][1] == pytest.approx(places[1][1], abs=1e-4)
        return places[1][0] - places[0][0]

    assert parallax(SCREEN_DISTANCE_CM) == pytest.approx(0, abs=1e-4)
    assert parallax(4 * SCREEN_DISTANCE_CM) > 1e-3  # behind the screen: uncrossed
    assert parallax(0.5 * SCREEN_DISTANCE_CM) < -1e-3


@pytest.mark.parametrize("display", DISPLAYS)
@pytest.mark.parametrize("size", [(640, 360), (641, 361)])
def test_viewports_tile_the_picture(display, size):
    views = views_for(display, size, pose(EYE, 0.0, 0.0))
    covered = np.zeros(size, int)
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
