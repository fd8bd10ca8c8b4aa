"""A camera's path: through its places at their times, smoothly, and at rest at the ends."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.curves import curve_at, curve_through

coordinate = st.floats(-500.0, 500.0)
place = st.tuples(coordinate, coordinate, coordinate)
legs = st.lists(st.floats(0.5, 20.0), min_size=3, max_size=8)


def laid(durations, data, loop):
    times = np.concatenate([[0.0], np.cumsum(durations)])
    places = np.array([data.draw(place) for _ in times])
    if loop:
        places[-1] = places[0]
    return curve_through(times, places, loop)


def acceleration(curve, t, side, h=1e-4):
    """From the velocities on one side of t alone."""
    now, beside = curve_at(curve, t + side * 1e-9)[1], curve_at(curve, t + side * h)[1]
    return side * (beside - now) / h


@pytest.mark.parametrize("loop", [False, True])
@given(durations=legs, data=st.data())
def test_it_passes_its_places_with_continuous_acceleration(loop, durations, data):
    curve = laid(durations, data, loop)
    for t, there in zip(curve.times, curve.places, strict=True):
        np.testing.assert_allclose(curve_at(curve, t)[0], there, atol=1e-6)
    scale = 1.0 + np.abs(curve.velocities).max() / min(durations)
    joints = curve.times[1:-1] if not loop else [*curve.times[1:-1], curve.times[-1]]
    for t in joints:
        before, after = acceleration(curve, t, -1.0), acceleration(curve, t, 1.0)
        np.testing.assert_allclose(before, after, atol=2e-3 * scale)


@given(durations=legs, data=st.data())
def test_velocity_is_the_slope_of_the_place(durations, data):
    curve = laid(durations, data, False)
    t, h = data.draw(st.floats(0.01, 0.99)) * curve.times[-1], 1e-5
    slope = (curve_at(curve, t + h)[0] - curve_at(curve, t - h)[0]) / (2 * h)
    scale = 1.0 + np.abs(curve.velocities).max()
    np.testing.assert_allclose(curve_at(curve, t)[1], slope, atol=1e-3 * scale)


@given(durations=legs, data=st.data())
def test_it_starts_and_ends_at_rest_and_stays_there(durations, data):
    curve = laid(durations, data, False)
    for t, k in ((0.0, 0), (-3.0, 0), (curve.times[-1], -1), (curve.times[-1] + 3.0, -1)):
        there, velocity = curve_at(curve, t)
        np.testing.assert_allclose(there, curve.places[k], atol=1e-6)
        np.testing.assert_allclose(velocity, 0.0, atol=1e-6)


@given(durations=legs, data=st.data())
def test_a_loop_goes_on_for_ever(durations, data):
    curve = laid(durations, data, True)
    t = data.draw(st.floats(0.0, 1.0)) * curve.times[-1]
    for one, other in zip(curve_at(curve, t), curve_at(curve, t + curve.times[-1]), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5 * (1.0 + np.abs(one).max()))


def test_a_circle_is_nearly_one():
    turn = np.linspace(0.0, 2 * np.pi, 9)
    places = 100.0 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    places[-1] = places[0]
    curve = curve_through(turn, places, loop=True)
    for t in np.linspace(0.0, 2 * np.pi, 50):
        there, velocity = curve_at(curve, t)
        assert abs(np.linalg.norm(there) - 100.0) < 0.3
        assert abs(np.linalg.norm(velocity) - 100.0) < 2.0
