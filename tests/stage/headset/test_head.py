"""The eyes of a head: axes, true scale, recentring and the rig of a headset."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.headset.head import (
    AT_ORIGIN,
    HeadEye,
    Home,
    Pose,
    head_eyes,
    headset_rig,
    home_of,
    on_observer,
    rotation_of,
    snapped,
)
from subsea.view.front_screen import front_screen, text_viewports
from subsea.view.rig import front, pose_from_angles, views
from tests.support.headset import APART_M, DOWN, IN, NOT_TURNED, OUT, UP, turned

SIZES = ((200, 210), (200, 210))
EYES = (
    HeadEye(Pose(np.array([-APART_M / 2, 0.0, 0.0]), NOT_TURNED), -OUT, IN, UP, -DOWN),
    HeadEye(Pose(np.array([APART_M / 2, 0.0, 0.0]), NOT_TURNED), -IN, OUT, UP, -DOWN),
)
OBSERVER = pose_from_angles(np.array([120.0, -40.0, -300.0]), 0.6, 0.0)
RIGHT, AHEAD = np.cross(OBSERVER.forward, OBSERVER.up), OBSERVER.forward


def seen(eyes=EYES, home=AT_ORIGIN):
    rig = headset_rig(SIZES, eyes, (160, 90))
    return views(rig._replace(eyes=head_eyes(eyes, [e.viewport for e in rig.eyes], home)), OBSERVER)


def pixel(view, point):
    """The pixel at which a view shows a point, from its lower left corner."""
    clip = view.projection.astype(float) @ view.view.astype(float) @ [*point, 1.0]
    share = 0.5 + 0.5 * clip[:2] / clip[3]
    return share * view.viewport[2:]


def tangent(view, point):
    """Tangents of the angles right and up at which an eye sees a point."""
    x, y, z = view.view[:3].astype(float) @ [*point, 1.0]
    return np.array([x, y]) / -z


def test_the_runtimes_angles_are_those_of_the_pictures_edges():
    left, right = seen()
    for view, (low, high) in ((left, (-OUT, IN)), (right, (-IN, OUT))):
        p = view.projection
        edges = [(side + p[0, 2]) / p[0, 0] for side in (-1.0, 1.0)]
        np.testing.assert_allclose(np.arctan(edges), (low, high), atol=1e-6)
        edges = [(side + p[1, 2]) / p[1, 1] for side in (-1.0, 1.0)]
        np.testing.assert_allclose(np.arctan(edges), (-DOWN, UP), atol=1e-6)


def test_a_fish_of_20_cm_at_1_m_subtends_what_it_should_in_both_eyes():
    """True scale: an eye half of 6.3 cm aside sees both ends at other angles."""
    middle = OBSERVER.eye + 100.0 * AHEAD
    for view, aside in zip(seen(), (-3.15, 3.15), strict=True):
        ends = [tangent(view, middle + half * RIGHT)[0] for half in (-10.0, 10.0)]
        np.testing.assert_allclose(ends, [(-10.0 - aside) / 100.0, (10.0 - aside) / 100.0],
                                   atol=1e-5)  # fmt: skip


@given(st.floats(40.0, 3000.0))
def test_parallax_is_that_of_the_distance(far):
    """Exchanged eyes would give the opposite sign."""
    left, right = (tangent(view, OBSERVER.eye + far * AHEAD)[0] for view in seen())
    assert left - right == pytest.approx(100.0 * APART_M / far, rel=1e-3)


@pytest.mark.parametrize(
    ("orientation", "way"),
    [
        (turned(30.0, (0.0, 1.0, 0.0)), (-0.5, 0.0, np.sqrt(0.75))),  # to the left
        (turned(30.0, (1.0, 0.0, 0.0)), (0.0, 0.5, np.sqrt(0.75))),  # up
        (turned(30.0, (0.0, 0.0, 1.0)), (0.0, 0.0, 1.0)),  # it tilts to the left
    ],
)
def test_a_turned_head(orientation, way):
    offset, axes = on_observer(Pose(np.array([0.1, 0.2, -0.3]), orientation), AT_ORIGIN)
    np.testing.assert_allclose(offset, (10.0, 20.0, 30.0))
    np.testing.assert_allclose(axes[2], way, atol=1e-9)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(axes) == pytest.approx(1.0)  # not mirrored
    if way[2] == 1.0:
        np.testing.assert_allclose(axes[1], (-0.5, np.sqrt(0.75), 0.0), atol=1e-9)


@given(
    st.floats(-np.pi, np.pi), st.floats(-1.0, 1.0), st.floats(-0.4, 0.4),
    st.tuples(*3 * [st.floats(-2.0, 2.0)]),
)  # fmt: skip
def test_recentred_it_sits_at_the_place_of_the_pilot_and_looks_ahead(yaw, pitch, roll, place):
    """Its pitch and roll stay: the horizon must not tilt."""
    half = np.array([yaw, pitch, roll]) / 2.0
    (cy, cx, cz), (sy, sx, sz) = np.cos(half), np.sin(half)
    pose = Pose(np.array(place), np.array([
        cy * sx * cz + sy * cx * sz, sy * cx * cz - cy * sx * sz,
        cy * cx * sz - sy * sx * cz, cy * cx * cz + sy * sx * sz,
    ]))  # fmt: skip
    offset, axes = on_observer(pose, home_of([HeadEye(pose, -1.0, 1.0, 1.0, -1.0)] * 2))
    np.testing.assert_allclose(offset, 0.0, atol=1e-9)
    assert axes[2, 0] == pytest.approx(0.0, abs=1e-9) and axes[2, 2] > 0.0
    assert axes[2, 1] == pytest.approx(rotation_of(pose.orientation)[1, 2] * -1.0)


def test_a_head_that_looks_straight_up_has_a_home():
    pose = Pose(np.zeros(3), turned(90.0, (1.0, 0.0, 0.0)))
    assert home_of([HeadEye(pose, -1.0, 1.0, 1.0, -1.0)]).yaw == 0.0


def test_the_head_moves_in_the_direction_that_it_was_recentred_to():
    home = Home(np.array([1.0, 1.6, 2.0]), np.pi / 2.0)  # looking to the left, along -x
    offset, axes = on_observer(Pose(np.array([0.5, 1.6, 2.0]), turned(90.0, (0.0, 1.0, 0.0))), home)
    np.testing.assert_allclose(offset, (0.0, 0.0, 50.0), atol=1e-9)
    np.testing.assert_allclose(axes, np.eye(3), atol=1e-9)


def test_the_window_mirrors_the_middle_of_the_left_picture_whatever_the_head_does():
    rig = headset_rig(SIZES, EYES, (160, 90))
    ahead = front(rig)
    assert ahead.output == 0 and rig.outputs == ((160, 90), *SIZES)
    x, y, width, height = ahead.left
    assert (x, width) == (0, 200) and height == round(200 * 90 / 160)
    assert y == (210 - height) // 2
    right = head_eyes(
        [
            eye._replace(pose=eye.pose._replace(orientation=turned(-40.0, (0, 1, 0))))
            for eye in EYES
        ],
        [eye.viewport for eye in rig.eyes],
    )
    assert front(rig._replace(eyes=right)) is ahead
    assert text_viewports(rig)[0][:4] == (0.0, 0.0, 1.0, 1.0)


def test_a_point_in_the_window_is_the_one_that_its_picture_shows_there():
    """The window shows a part of the view."""
    rig = headset_rig(SIZES, EYES, (160, 90))
    seen_there = views(rig, OBSERVER)
    screen = front_screen(rig, seen_there)
    for x, y in ((0.5, 0.5), (0.1, 0.9), (0.8, 0.2)):
        eye, way = screen.ray(x, y)
        at = pixel(seen_there[0], eye + 300.0 * way)
        left, bottom, width, height = front(rig).left
        np.testing.assert_allclose(at, (left + x * width, bottom + (1.0 - y) * height), atol=1e-2)
        np.testing.assert_allclose(screen.places((eye + 300.0 * way)[None])[0], (x, y), atol=1e-4)


def test_a_view_that_turns_in_steps_waits_until_the_next_is_nearer():
    step = np.radians(30.0)
    shown, found = 0.0, []
    for degrees in (10, 17, 19, 25, 13, 11, -20, 179, 195):
        shown = snapped(np.radians(degrees), shown, step)
        found.append(round(float(np.degrees(shown)) % 360))
    assert found == [0, 0, 30, 30, 30, 0, 330, 180, 180]
