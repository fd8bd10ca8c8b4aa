"""Segments seen from above, against a motion that is known in closed form (tests/conftest.py)."""

import dataclasses

import numpy as np
import pytest

from capture.inspection.top_view import above, lateral_offset, midline, spectrum, speeds, top_view

LENGTH, TICK_S, FRAMES = 20.0, 0.033, 12


def test_ahead_is_real_and_left_is_imaginary():
    assert above(np.array([2.0, 5.0, 3.0])) == 2 - 3j


def test_the_midline_goes_from_the_nose_through_the_rings_to_the_tail(known_repertoire):
    line = midline(known_repertoire.rest_nodes)
    np.testing.assert_allclose(line[0, 0] - line[:, 0], [0.0, 2.0, 5.0, 10.0, 14.7, 17.8, 20.0])
    np.testing.assert_allclose(line[:, 1:], 0, atol=1e-12)
    many = midline(np.stack([known_repertoire.rest_nodes] * 3))
    np.testing.assert_array_equal(many, np.stack([line] * 3))


@pytest.mark.parametrize(
    ("name", "amplitude", "side"),
    [("swim_fast", 0.10, 0), ("turn_left_gradual", 0.06, 1), ("turn_right_gradual", 0.06, -1)],
)
def test_the_offset_from_a_straight_or_circular_path_is_the_given_wave(
    known_repertoire, name, amplitude, side
):
    segment = known_repertoire.segments[name]
    found = lateral_offset(segment, cycles=3)
    found = found - found.mean(axis=0)
    back = np.array([0.0, 2.0, 5.0, 10.0, 14.7, 17.8, 20.0]) / LENGTH
    phase = 2 * np.pi * np.arange(1, 3 * FRAMES + 1)[:, None] / FRAMES
    wave = amplitude * LENGTH * back**2 * np.sin(phase - 5.0 * back)
    if side:  # the distance to the centre of the circle, which is abreast of the second ring
        radius = 0.5 * 20 * TICK_S / np.radians(1.5)
        wave = side * np.hypot(LENGTH * (0.25 - back), radius + side * wave)
        wave -= wave.mean(axis=0)
    np.testing.assert_allclose(found, wave, atol=1e-9)


@pytest.mark.parametrize("name", ["turn_left_gradual", "turn_right_gradual", "swim_slow"])
def test_a_cycle_is_replayed_along_its_path(known_repertoire, name):
    """It begins straight ahead, and then curves to its side."""
    segment = known_repertoire.segments[name]
    nose = top_view(segment, 10).midline[:, 0]  # in this motion the nose doesn't sway
    steps = np.diff(nose)
    turn = np.radians(segment.turn_deg) / FRAMES
    assert np.angle(steps[1:] / steps[:-1]) == pytest.approx(turn, abs=1e-9)
    if name == "swim_slow":
        assert np.angle(steps[0]) == pytest.approx(0, abs=1e-9)


def test_a_sharp_turn_is_measured_from_the_body_axis(known_repertoire):
    segment = known_repertoire.segments["turn_left_sharp"]
    np.testing.assert_array_equal(
        lateral_offset(segment, 3)[:, -1], segment.nodes[:, 21:, 2].mean(axis=1)
    )
    assert len(top_view(segment, 3).origin) == FRAMES


def test_the_speed_is_that_of_the_mean_of_all_nodes(known_repertoire):
    still = known_repertoire.segments["swim_fast"]
    stiff = dataclasses.replace(
        still,
        nodes=np.stack([known_repertoire.rest_nodes] * FRAMES),
        increment_rotation=np.tile([1.0, 0, 0, 0], (FRAMES, 1)),
        increment_translation=np.tile([0.5, 0, 0], (FRAMES, 1)),
    )
    np.testing.assert_allclose(speeds(stiff, TICK_S, 2), np.full(2 * FRAMES - 1, 0.5 / TICK_S))


@pytest.mark.parametrize("cyclic", [True, False])
def test_the_spectrum_finds_sines_and_their_amplitudes(cyclic):
    time = 0.02 * np.arange(100)
    values = 5 + 3 * np.sin(2 * np.pi * 4 * time) + 0.5 * np.cos(2 * np.pi * 12 * time)
    hertz, amplitude = spectrum(values, 0.02, cyclic)
    at = dict(zip(hertz.round(6), amplitude, strict=True))
    assert at[4.0] == pytest.approx(3)
    assert at[12.0] == pytest.approx(0.5)
    assert at[8.0] == pytest.approx(0, abs=1e-9)
