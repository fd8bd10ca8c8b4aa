"""Waves, turns and C-starts of closed form."""

import numpy as np
import pytest

from capture.inspection.kinematics import (
    body_wave,
    envelope_deviation,
    escape,
    path_radius,
    published_envelope,
    travelling_wave,
    turning_radius,
)
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


def test_angle_and_duration_of_an_escape(repertoire):
    """Ten ticks to 120 degrees at an even rate, then rest."""
    angle = np.radians(120) * np.minimum(np.arange(21) / 10, 1.0)
    segment = make_segment(
        carried(repertoire, angle, 1.0), repertoire.body_length_cm, "left", "sharp", False
    )
    assert escape(segment, TICK_S) == pytest.approx((120.0, 9 * TICK_S), rel=1e-6)


def test_the_wave_of_a_repertoire_beats_once_a_cycle(repertoire):
    segment = repertoire.segments["swim_fast"]
    found = body_wave(segment, repertoire)
    assert found.frequency == pytest.approx(1 / (len(segment.nodes) * repertoire.tick_s))
    assert 0.15 < found.amplitude < 0.25 and 0.8 < found.wavelength < 1.2
