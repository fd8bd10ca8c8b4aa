"""Quaternions against matrices."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry import rotation as rot

component = st.floats(-1, 1)
quaternions = (
    st.tuples(component, component, component, component)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: np.array(q) / np.linalg.norm(q))
)
vectors = st.tuples(*[st.floats(-10, 10)] * 3).map(np.array)


@given(quaternions, quaternions, vectors)
def test_product_is_first_the_right_factor(a, b, v):
    a, b, v = tuple(a), tuple(b), tuple(v)
    np.testing.assert_allclose(
        rot.rotate(rot.multiply(a, b), v), rot.rotate(a, rot.rotate(b, v)), atol=1e-12
    )


@given(quaternions, vectors)
def test_rotate_agrees_with_the_matrix(q, v):
    np.testing.assert_allclose(rot.matrix(q) @ v, rot.rotate(tuple(q), tuple(v)), atol=1e-12)


@given(quaternions)
def test_matrix_and_back(q):
    back = rot.from_matrix(rot.matrix(q))
    np.testing.assert_allclose(abs(back @ q), 1.0, atol=1e-12)
    assert back[0] >= 0


@given(quaternions)
def test_the_rotation_of_three_axes_is_that_of_their_matrix(q):
    x, y, z = (tuple(axis) for axis in rot.matrix(q).T)
    np.testing.assert_allclose(abs(np.array(rot.of_axes(x, y, z)) @ q), 1.0, atol=1e-12)


def test_half_turns_survive_the_way_through_a_matrix():
    for axis in np.eye(3):
        q = np.array([0.0, *axis])
        np.testing.assert_allclose(rot.from_matrix(rot.matrix(q)), q, atol=1e-12)


@given(quaternions, st.floats(0, 1))
def test_parts_of_a_rotation_join_to_the_whole(q, f):
    joined = rot.multiply(rot.fraction(tuple(q), f), rot.fraction(tuple(q), 1 - f))
    np.testing.assert_allclose(abs(joined @ q), 1.0, atol=1e-9)


@given(st.floats(-3.1, 3.1), st.floats(-2, 2))
def test_fraction_scales_the_angle(angle, f):
    part = rot.fraction(rot.about(0.0, 1.0, 0.0, angle), f)
    expected = rot.about(0.0, 1.0, 0.0, f * angle)
    np.testing.assert_allclose(part, expected, atol=1e-9)


@given(st.floats(-30, 30))
def test_any_power_of_no_rotation_is_none(f):
    assert tuple(rot.fraction((1.0, 0.0, 0.0, 0.0), f)) == (1.0, 0.0, 0.0, 0.0)


def test_a_positive_angle_about_the_back_turns_left():
    ahead = rot.rotate(rot.about(0.0, 1.0, 0.0, 0.1), (1.0, 0.0, 0.0))
    assert ahead[2] < 0  # z is right
