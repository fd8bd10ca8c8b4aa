"""Balancing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.rotation import about, multiply
from subsea.motor.containment import roll_of
from subsea.motor.playback import play
from tests.support.scenes import everyone

TICK = 0.033
STILL = np.zeros(3)


@given(roll=st.floats(-3.1, 3.1), heading=st.floats(-3.1, 3.1), pitch=st.floats(-1.2, 1.2))
def test_roll_has_the_right_sign_and_size(roll, heading, pitch):
    q = multiply(about(0.0, 0.0, 1.0, heading), about(1.0, 0.0, 0.0, np.pi / 2))
    q = multiply(multiply(q, about(0.0, 0.0, 1.0, pitch)), about(1.0, 0.0, 0.0, roll))
    np.testing.assert_allclose(roll_of(q), roll, atol=1e-9)


@pytest.mark.parametrize("roll_deg", [-179.0, -90.0, -15.0, 15.0, 90.0, 179.0])
def test_a_rolled_fish_rights_itself_at_a_bounded_rate(library, make_fishes, roll_deg):
    fishes = make_fishes(1, "swim_slow")
    upright = about(1.0, 0.0, 0.0, np.pi / 2)
    fishes.orientation[0] = multiply(upright, about(1.0, 0.0, 0.0, np.radians(roll_deg)))
    rolls = [np.radians(roll_deg)]
    for _ in range(400):
        play(everyone(fishes), fishes, library, TICK)
        rolls.append(roll_of(tuple(fishes.orientation[0].astype(float))))
    assert abs(rolls[-1]) < np.radians(1.0)
    assert np.abs(np.diff(np.unwrap(rolls))).max() < np.radians(56) * TICK
    unwrapped = np.unwrap(rolls) * np.sign(roll_deg)
    assert unwrapped.min() > -np.radians(2.0)  # no swinging past upright
