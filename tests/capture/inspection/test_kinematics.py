"""Waves, turns and C-starts of closed form."""

import numpy as np
import pytest

from capture.inspection.kinematics import (
    body_bend,
    body_wave,
    envelope_deviation,
    escape,
    path_radius,
    posture,
    published_envelope,
    travelling_wave,
    turning,
    turning_radius,
)
from capture.inspection.simulated import replay
from capture.inspection.top_view import above, lateral_offset
from subsea.repertoire.segments import make_segment

TICK_S = 0.033
STATIONS = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.85, 1.0])


def wave(wavelength=0.95, beats=2, ticks=31):
    """The published carangiform wave (ticks, 7), body lengths."""
    phase = 2 * np.pi * (STATIONS / wavelength - beats * np.arange(ticks)[:, None] / ticks)
    return np.asarray(published_envelope("carangiform", STATIONS) * np.sin(phase))


@pytest.mark.parametrize("wavelength", [0.6, 0.95, 1.3])
def test_a_travelling_wave_has_its_envelope_length_and_frequency(wavelength):
    found = travelling_wave(wave(wavelength), STATIONS, TICK_S)
    assert found.wavelength == pytest.approx(wavelength, rel=1e-6)
    assert found.envelope == pytest.approx(published_envelope("carangiform", STATIONS), rel=0.01)
    assert found.frequency == pytest.approx(2 / (31 * TICK_S))
    assert found.amplitude == pytest.approx(0.2, rel=0.01)
    off, _ = envelope_deviation("carangiform", found)
    assert off < 1e-3
    raised = found._replace(envelope=found.envelope + 0.03 * (STATIONS == 0.7))
    assert envelope_deviation("carangiform", raised) == pytest.approx((0.03, 0.7), abs=1e-3)


def test_eels_may_lie_between_two_envelopes():
    found = travelling_wave(wave(), STATIONS, TICK_S)
    for alpha, off in ((1.0, 0.0), (1.5, 0.0), (2.0, 0.0), (0.0, 0.1 - 0.1 / np.e)):
        eel = found._replace(envelope=0.1 * np.exp(alpha * (STATIONS - 1)))
        assert envelope_deviation("anguilliform", eel)[0] == pytest.approx(off, abs=1e-9)


def test_the_radius_of_a_circle():
    angle = np.linspace(0, 1.2, 60)
    middle = 7.0 * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=-1)
    assert path_radius(middle, angle) == pytest.approx(7.0, rel=1e-3)
    assert path_radius(middle[:, ::-1], -angle) == pytest.approx(7.0, rel=1e-3)
    assert path_radius(middle[[0, -1]], angle[[0, -1]]) == pytest.approx(7.0, rel=1e-9)
    assert np.isnan(path_radius(middle, 0 * angle))


def carried(repertoire, heading, radius):
    """The body at rest (t, 23, 3) along a circle to the left, with headings (t,) in rad."""
    turn = np.zeros((len(heading), 3, 3))
    turn[:, 0, 0] = turn[:, 2, 2] = np.cos(heading)
    turn[:, 1, 1] = 1.0
    turn[:, 0, 2], turn[:, 2, 0] = np.sin(heading), -np.sin(heading)
    place = radius * np.stack([np.sin(heading), 0 * heading, np.cos(heading) - 1], axis=-1)
    body = repertoire.rest_nodes - repertoire.rest_nodes.mean(axis=0)
    return np.asarray(body @ np.swapaxes(turn, 1, 2) + place[:, None])


def test_a_rigid_body_on_a_circle_turns_with_its_radius(repertoire):
    frames = carried(repertoire, np.linspace(0.0, 1.5, 40), 30.0)
    for cyclic in (False, True):
        segment = make_segment(frames, repertoire.body_length_cm, "left", "sharp", cyclic)
        found = turning_radius(segment, repertoire.body_length_cm) * repertoire.body_length_cm
        assert found == pytest.approx(30.0, rel=1e-3)


def test_net_angle_and_duration_of_an_escape(repertoire):
    """Ten ticks to 120 degrees at an even rate, then rest."""
    angle = np.radians(120) * np.minimum(np.arange(41) / 10, 1.0)
    length = repertoire.body_length_cm
    segment = make_segment(carried(repertoire, angle, 1.0), length, "left", "wide", False)
    assert escape(segment, TICK_S) == pytest.approx(9 * TICK_S, rel=1e-6)
    # A peak on the way does not count.
    angle[10:20] += np.radians(30)
    segment = make_segment(carried(repertoire, angle, 1.0), length, "left", "wide", False)
    assert turning(segment, length, True, 20).net == pytest.approx(120.0, abs=13.0)


@pytest.mark.parametrize("rate", [0.02, 0.06])
def test_a_turn_on_a_circle_has_its_acceleration_and_no_bend(repertoire, rate):
    """The middle of a rigid body on a circle of 1.5 lengths is pulled inwards by ω² r."""
    length = repertoire.body_length_cm
    frames = carried(repertoire, rate * np.arange(40), 1.5 * length)
    seen = turning(make_segment(frames, length, "left", "sharp", False), length, True, 5)
    assert seen.acceleration == pytest.approx(1.5 * rate**2, rel=0.02)
    assert np.isnan(seen.into)


@pytest.mark.parametrize("angle", [-70.0, -20.0, 0.0, 35.0, 100.0])
def test_the_bend_is_the_angle_of_the_head_to_the_left(repertoire, angle):
    body, turn = repertoire.rest_nodes.copy(), np.radians(angle)
    body[0] = body[9:13].mean(axis=0) + 8.0 * np.array([np.cos(turn), 0.0, -np.sin(turn)])
    assert body_bend(body[None]) == pytest.approx(angle)


@pytest.mark.parametrize(("left", "into"), [(True, 1.0), (False, 0.0)])
def test_a_body_bent_to_the_left_is_bent_into_turns_to_the_left(repertoire, left, into):
    """A body with its nose held to the left goes round to the left, or to the right."""
    length, side = repertoire.body_length_cm, 1.0 if left else -1.0
    frames = carried(repertoire, side * 0.05 * np.arange(30), side * 1.5 * length)
    middle, ahead = frames[:, 9:13].mean(axis=1), frames[:, 0] - frames[:, 9:13].mean(axis=1)
    turned = above(ahead) * np.exp(1j * np.radians(50.0))
    frames[:, 0] = middle + np.stack([turned.real, ahead[:, 1], -turned.imag], axis=-1)
    segment = make_segment(frames, length, "left" if left else "right", "sharp", False)
    assert turning(segment, length, left, 5).into == into


def test_the_snout_the_yaw_and_the_roll_of_a_swim(repertoire):
    """Beside what the nodes of the file show."""
    segment = repertoire.segments["swim_fast"]
    held = posture(segment, body_wave(segment, repertoire))
    aside = lateral_offset(segment)
    snout, tail = np.ptp(aside[:, [0, -1]], axis=0)
    assert held.snout_over_tail == pytest.approx(snout / tail, abs=0.02)
    frames = replay(segment, np.zeros(3), np.eye(3), 2)
    ahead = above(frames[:, 0] - frames[:, [5, 7]].mean(axis=1))
    assert held.yaw == pytest.approx(np.ptp(np.degrees(np.unwrap(np.angle(ahead)))), abs=0.1)
    assert 0.0 <= held.roll < 10.0 and 0.0 < held.snout < 10.0


def test_the_wave_of_a_repertoire_beats_once_a_cycle(repertoire):
    segment = repertoire.segments["swim_fast"]
    found = body_wave(segment, repertoire)
    assert found.frequency == pytest.approx(1 / (len(segment.nodes) * repertoire.tick_s))
    assert 0.15 < found.amplitude < 0.25 and 0.8 < found.wavelength < 1.2
