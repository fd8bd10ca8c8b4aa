"""The rules that a spine swings by."""

from itertools import product

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.fish.spine import (
    MIDDLES,
    UNITS,
    Spines,
    Swing,
    Wings,
    bend_points,
    chain_points,
    flap_wings,
    phase,
    pose_spine,
    swing_angles,
)

FUNCTIONS, PROPAGATIONS = ["sinusoidal", "linear"], ["tailward", "outward", "at once"]
EVEN = ((0.0, 1.0), (1.0, 1.0))
MASS = np.ones(UNITS)
SWING = {"angle": 40.0, "inflections": (0.2, 0.5, 0.8), "flexibility": EVEN}


def swing(**changes):
    return msgspec.convert(SWING | changes, Swing)


class Plan(msgspec.Struct):
    """The part of a plan that `pose_spine` reads."""

    swing: Swing
    centre: float = 0.4


def straight(plan, beat, amplitude=1.0):
    beat = np.atleast_1d(np.asarray(beat, float))
    return pose_spine(plan, beat, amplitude, np.zeros((len(beat), UNITS)), MASS)


@given(st.floats(0, 3), st.floats(-2, 2), st.sampled_from(FUNCTIONS), st.sampled_from(PROPAGATIONS))
def test_the_spine_keeps_its_length(beat, bend, function, propagation):
    plan = Plan(swing(function=function, propagation=propagation))
    path = bend * (plan.centre - MIDDLES)[None]
    place, _ = pose_spine(plan, np.array([beat]), 1.0, path, MASS)
    units = np.linalg.norm(np.diff(place[0], axis=0), axis=1)
    np.testing.assert_allclose(units, 1.0 / UNITS, rtol=1e-9)


def test_the_central_inflection_point_swings_farthest_as_the_beat_begins():
    for function, propagation in product(FUNCTIONS, PROPAGATIONS):
        one = swing(function=function, propagation=propagation)
        there = np.array(one.inflections)
        expected = np.radians(40.0) * np.array([-1.0, 1.0, -1.0])
        for beat, sign in ((0.0, 1), (0.5, -1), (1.0, 1)):
            found = swing_angles(one, there, beat, 1.0)
            np.testing.assert_allclose(found, sign * expected, atol=1e-9)


def test_with_the_linear_function_neighbours_differ_by_equal_angles():
    one = swing(function="linear")
    first, central, last = one.inflections
    for a, b in ((first, central), (central, last)):
        steps = np.diff(swing_angles(one, np.linspace(a, b, 20), 0.0, 1.0))
        np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    sinusoidal = np.diff(swing_angles(swing(), np.linspace(first, central, 20), 0.0, 1.0))
    assert sinusoidal.max() > 5 * sinusoidal.min()


def test_the_wave_runs_tailward_at_a_wavelength_each_beat():
    one = swing(inflections=(0.1, 0.45, 0.8))
    assert one.wavelength == pytest.approx(0.7)
    later = swing_angles(one, MIDDLES + 0.1 * one.wavelength, 0.1, 1.0)
    np.testing.assert_allclose(later, swing_angles(one, MIDDLES, 0.0, 1.0), atol=1e-9)


def test_a_swing_that_arrives_everywhere_at_once_leaves_its_nodes_in_place():
    one = swing(propagation="at once")
    between = np.array([0.35, 0.65])  # half-way between inflection points the spine never turns
    for beat in np.linspace(0, 1, 7):
        np.testing.assert_allclose(swing_angles(one, between, beat, 1.0), 0.0, atol=1e-9)


def test_outward_both_ends_follow_the_centre():
    one = swing(propagation="outward")
    for beat in np.linspace(0, 1, 7):
        before, behind = swing_angles(one, np.array([0.4, 0.6]), beat, 1.0)
        assert before == pytest.approx(behind)
        assert before == pytest.approx(
            float(swing_angles(one, np.array([0.5]), beat - 1 / 6, 1.0)[0])
        )


def test_zero_flexibility_is_rigid():
    stiff = swing(flexibility=((0.0, 0.0), (0.5, 0.0), (1.0, 1.2)))
    _, direction = straight(Plan(stiff), np.linspace(0, 1, 9))
    head = direction[:, MIDDLES < 0.5]
    np.testing.assert_allclose(head, head[:, :1] * np.ones_like(head), atol=1e-12)
    assert np.ptp(direction[:, -1] - direction[:, 0]) > np.radians(90)
    place, direction = straight(Plan(swing(flexibility=((0.0, 0.0), (1.0, 0.0)))), [0.0, 0.3])
    np.testing.assert_allclose(direction, 0.0, atol=1e-12)
    np.testing.assert_allclose(place[..., 1], 0.0, atol=1e-12)


def test_a_head_that_suppresses_and_a_tail_that_amplifies():
    _, direction = straight(
        Plan(swing(flexibility=((0.0, 0.1), (1.0, 1.3)))), np.linspace(0, 1, 40)
    )
    sweep = np.ptp(direction, axis=0)
    assert sweep[-1] > 4 * sweep[0]


def test_the_mass_neither_sways_nor_yaws():
    plan = Plan(swing(flexibility=((0.0, 0.1), (1.0, 1.0))))
    place, _ = straight(plan, np.linspace(0, 1, 25))
    x, y = np.moveaxis(0.5 * (place[:, 1:] + place[:, :-1]), -1, 0)
    rest = plan.centre - MIDDLES
    np.testing.assert_allclose(y.mean(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose((y * (rest - rest.mean())).mean(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(x.mean(axis=1), rest.mean(), atol=1e-12)


def test_a_flexible_body_lies_on_its_path():
    """On a circle, without a swing, every unit lies on the circle."""
    plan = Plan(swing(angle=0.0))
    bend = 1.7
    place, _ = pose_spine(plan, np.zeros(1), 1.0, bend * (plan.centre - MIDDLES)[None], MASS)
    distance = np.linalg.norm(place[0] - (0.0, 1.0 / bend), axis=1)
    np.testing.assert_allclose(distance, 1.0 / bend, rtol=1e-4)


@given(st.floats(0, 1), st.floats(0, 2 * np.pi), st.floats(0.001, 0.05), st.floats(0, 1))
def test_surface_points_keep_their_distance_to_their_place_on_the_spine(at, angle, far, beat):
    spine = straight(Plan(swing()), beat)
    points = np.array([[at, 0.0, 0.0], [at, far * np.cos(angle), far * np.sin(angle)]])
    axis, point = bend_points(spine, points)[0]
    assert np.linalg.norm(point - axis) == pytest.approx(far, rel=1e-9)
    theta = np.interp(at, MIDDLES, spine.direction[0])
    assert (point - axis) @ (np.cos(theta), 0.0, -np.sin(theta)) == pytest.approx(0.0, abs=1e-12)


def test_a_straight_spine_carries_the_body_as_it_is():
    still = Spines(-chain_points(np.zeros((1, UNITS))), np.zeros((1, UNITS)))
    points = np.array([[-0.02, 0.1, 0.0], [0.3, -0.1, 0.2], [1.05, 0.0, -0.1]])
    np.testing.assert_allclose(bend_points(still, points)[0], points * (-1, 1, 1), atol=1e-12)


WINGS = msgspec.convert(
    {
        "swing": SWING | {"inflections": (-1.6, 0.0, 1.6), "propagation": "outward"},
        "chord": (0.1, 0.4),
        "chord_lag": 0.25,
    },
    Wings,
)
SPAN = 0.3


@given(st.floats(0.01, 1.0), st.floats(0, 1), st.floats(0, 0.5))
def test_a_wing_keeps_its_length(reach, beat, at):
    line = np.zeros((33, 3))
    line[:, 0] = at
    line[:, 2] = np.linspace(0.0, reach * SPAN, 33)
    there = flap_wings(WINGS, line, SPAN, np.array([beat]), 1.0)[0]
    length = np.linalg.norm(np.diff(there, axis=0), axis=1).sum()
    assert length == pytest.approx(reach * SPAN, rel=2e-3)


def test_wings_are_mirrored_and_their_rear_follows_their_front():
    tips = np.array([[0.1, 0, SPAN], [0.4, 0, SPAN], [0.1, 0, -SPAN], [0.4, 0, -SPAN]])
    body = np.tile([0.2, 0.0, 0.0], (400, 1))  # so heavy that the wings hardly move it
    points = np.concatenate([tips, body])
    up = flap_wings(WINGS, points, SPAN, np.linspace(0, 1, 41), 1.0)[:, :4]
    np.testing.assert_allclose(up[:, :2] * (1, 1, -1), up[:, 2:], atol=1e-12)
    rise = up[:-1, :, 1]
    front, rear = (rise[:, k] - rise[:, k].mean() for k in (0, 1))
    lags = [float(np.roll(front, k) @ rear) for k in range(40)]
    assert int(np.argmax(lags)) == pytest.approx(0.25 * 40, abs=1)


def test_the_phase_meets_the_inflection_points_however_they_lie():
    one = swing(inflections=(0.16, 0.5, 0.8))
    np.testing.assert_allclose(phase(one, np.array(one.inflections)), [-np.pi, 0, np.pi], atol=1e-9)


def test_absurd_swings_are_refused():
    for changes, words in (
        ({"inflections": (0.2, 0.5, 0.52)}, "inflections"),
        ({"inflections": (0.1, 0.2, 0.9)}, "turn back"),
        ({"flexibility": ((0.5, 1.0), (0.2, 1.0))}, "flexibility"),
        ({"flexibility": ((0.0, -0.1), (1.0, 1.0))}, "flexibility"),
        ({"angle": 120.0}, "angle"),
        ({"angle": float("nan")}, "angle"),
        ({"function": "square"}, "function"),
        ({"stiffness": 1.0}, "stiffness"),
    ):
        with pytest.raises(msgspec.ValidationError, match=words):
            swing(**changes)
