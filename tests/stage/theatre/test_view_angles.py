"""Rotations of other programs and the three angles of a view say the same."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import (
    ViewAngles,
    angles_of,
    flipped,
    quaternion_rotation,
    turned,
    turns,
)
from subsea.view.camera import axes_of

HALF_TURN = st.floats(-180, 180)


@given(HALF_TURN, st.floats(-90, 90), HALF_TURN)
def test_heading_pitch_and_roll_of_a_right_handed_rotation(heading, pitch, roll):
    rotation = turns(1, -heading) @ turns(0, pitch) @ turns(2, -roll)
    expected = axes_of(*np.radians([heading, pitch, roll]))
    np.testing.assert_allclose(axes_of(*np.radians(turned(rotation))), expected, atol=2e-4)
    # Its columns are right, up and astern.
    np.testing.assert_allclose(flipped(rotation.T * [[1], [1], [-1]]), expected, atol=1e-9)


@given(st.lists(st.floats(-1, 1), min_size=4, max_size=4))
def test_quaternions_are_rotations(numbers):
    rotation = quaternion_rotation(np.array(numbers))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_a_quaternion_about_y_turns_to_the_left():
    half = np.radians(30) / 2
    found = turned(quaternion_rotation(np.array([0, np.sin(half), 0, np.cos(half)])))
    assert found == pytest.approx((-30, 0, 0), abs=1e-6)


def test_a_view_beyond_the_range_of_a_theatre_file_names_its_key():
    view = ViewAngles(0, 0, 0, -30, 95, -20, 20)
    with pytest.raises(UserError, match="right_deg"):
        angles_of(view)
