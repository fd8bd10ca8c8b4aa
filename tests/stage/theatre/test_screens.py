"""Screens and frusta: where points are, and that every matrix agrees with the screen."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.theatre.screens import (
    Curved,
    Flat,
    frustum_of,
    part_of,
    places_on,
    points_on,
    screen_of,
    seen_at,
)
from subsea.stage.theatre.theatre_file import Angles, Cylinder, Plane
from subsea.view.camera import NEAR_CM, off_axis

WALL = Plane(lower_left=(-150, -100, 200), lower_right=(150, -100, 260), upper_left=(-150, 90, 200))
ROUND = Cylinder(radius_cm=275, left_deg=-30, right_deg=25, bottom_cm=-120, top_cm=110,
                 axis_cm=(10, -20))  # fmt: skip
LEANING = Angles(left_deg=-30, right_deg=25, down_deg=-15, up_deg=20, heading_deg=40,
                 pitch_deg=10, roll_deg=-8)  # fmt: skip
TABLES = {"plane": WALL, "cylinder": ROUND, "angles": LEANING}
share = st.floats(0.0, 1.0)


def made(kind, eye=(0.0, 0.0, 0.0), scale=1.0):
    return screen_of(TABLES[kind], np.array(eye), scale)


@pytest.mark.parametrize("kind", TABLES)
@given(s=share, t=share)
def test_a_ray_to_a_point_of_a_screen_meets_it_there(kind, s, t):
    screen = made(kind)
    point = points_on(screen, np.array([[s, t]]))
    np.testing.assert_allclose(places_on(screen, 0.01 * point), [[s, t]], atol=1e-9)
    if isinstance(screen, Flat):  # what lies behind is not seen
        assert np.isnan(places_on(screen, -point)).all()


@pytest.mark.parametrize("kind", TABLES)
@given(s=share, t=share, away=st.floats(0.2, 50), side=st.sampled_from([-3.2, 0.0, 3.2]))
def test_a_point_lands_where_the_ray_to_the_eye_meets_the_screen(kind, s, t, away, side):
    """Through the matrices of the eye's frustum and through the plain geometry alike."""
    screen, eye = made(kind), np.array([side, 0.0, 0.0])
    corners = points_on(screen, np.array([[x, y] for x in np.linspace(0, 1, 40) for y in (0, 1)]))
    frustum = frustum_of(screen, eye, corners)
    on_screen = points_on(screen, np.array([[s, t]]))
    point = eye + away * (on_screen - eye)  # anywhere on the ray
    seen = (point - eye) @ frustum.axes.T
    projection = off_axis(*(NEAR_CM * edge for edge in frustum.edges))
    clip = projection.astype(float) @ [*(seen[0] * [1, 1, -1]), 1.0]
    ndc = clip[:2] / clip[3]
    expected = seen_at(frustum, eye, on_screen)[0]
    np.testing.assert_allclose(0.5 + 0.5 * ndc, expected, atol=2e-5)
    if isinstance(screen, Flat):  # its own plane: pixels are where the projector puts them
        np.testing.assert_allclose(expected, [s, t], atol=1e-6)
    assert (expected > -0.02).all()
    assert (expected < 1.02).all()


@pytest.mark.parametrize("kind", TABLES)
@given(x=st.floats(0, 0.9), y=st.floats(0, 0.9), w=st.floats(0.05, 0.1), s=share, t=share)
def test_a_part_of_a_screen_lies_where_it_did(kind, x, y, w, s, t):
    screen = made(kind)
    part = part_of(screen, (x, y, w, w))
    np.testing.assert_allclose(
        points_on(part, np.array([[s, t]])),
        points_on(screen, np.array([[x + w * s, y + w * t]])),
        atol=1e-9,
    )


@given(x=st.floats(-50, 50), y=st.floats(-50, 50), z=st.floats(-50, 50), scale=st.floats(0.1, 10))
def test_the_eye_s_place_and_the_scale_move_screens_about_it(x, y, z, scale):
    for kind in ("plane", "cylinder"):
        here = points_on(made(kind), np.array([[0.3, 0.6]]))
        there = points_on(made(kind, (x, y, z), scale), np.array([[0.3, 0.6]]))
        np.testing.assert_allclose(there, scale * (here - [x, y, z]), atol=1e-6)


def test_angles_turn_right_then_up_then_clockwise():
    straight = screen_of(
        Angles(left_deg=-10, right_deg=10, down_deg=-10, up_deg=10, heading_deg=90), np.zeros(3), 1
    )
    middle = points_on(straight, np.array([[0.5, 0.5]]))[0]
    np.testing.assert_allclose(middle, [300, 0, 0], atol=1e-9)
    rolled = screen_of(
        Angles(left_deg=-10, right_deg=10, down_deg=-10, up_deg=10, roll_deg=90), np.zeros(3), 1
    )
    top = points_on(rolled, np.array([[0.5, 1.0]]))[0]
    assert top[0] > 50  # what was up is right now
    assert abs(top[1]) < 1e-9


def test_a_cylinder_s_middle_is_straight_ahead():
    screen = made("cylinder")
    assert isinstance(screen, Curved)
    point = points_on(screen, np.array([[30 / 55, 120 / 230]]))[0]
    np.testing.assert_allclose(point, [10, 0, 255], atol=1e-9)
