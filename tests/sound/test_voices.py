"""Spectra of single events."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.sound.space import RATE
from subsea.sound.voices import (
    BUBBLE,
    CREAK,
    CRUNCH,
    GLIDE,
    KNOCK,
    LONGEST,
    POP,
    RINGS,
    SNAP,
    STRIKE,
    WHOOSH,
    minnaert_hz,
    next_noise,
    noise_seed,
    sing,
    white,
)

ALL = (SNAP, BUBBLE, POP, CRUNCH, WHOOSH, STRIKE, KNOCK, CREAK)


def sound(voice, size=1000.0, pitch=1.0, seed=1):
    out = np.full(LONGEST, np.nan)
    return out[: sing(voice, size, pitch, seed, out)]


def spectrum(samples):
    """Frequencies and power, to the hertz."""
    power = np.abs(np.fft.rfft(samples, RATE)) ** 2
    return np.arange(len(power)), power


def share(samples, low, high):
    hz, power = spectrum(samples)
    return power[(hz >= low) & (hz <= high)].sum() / power.sum()


def test_minnaert():
    # About 3.26 m/s over the radius at the surface, and twice as high under four atmospheres.
    assert minnaert_hz(0.1, 0.0) == pytest.approx(3260.0, rel=0.01)
    assert minnaert_hz(0.1, 3 * 1008.0) == pytest.approx(2.0 * minnaert_hz(0.1, 0.0), rel=0.01)


@given(st.floats(0.1, 1.0), st.floats(0.0, 3000.0))
def test_bubbles_ring_at_their_resonance(radius, depth):
    expected = minnaert_hz(radius, depth)
    hz, power = spectrum(sound(BUBBLE, expected))
    # While it fades, in RINGS oscillations, its pitch rises.
    assert 0.995 * expected < hz[power.argmax()] < 1.005 * expected + GLIDE * RINGS


@given(st.integers(0, 2**31))
def test_snaps_of_shrimp_are_short_clicks_of_2_to_15_khz(seed):
    snap = sound(SNAP, seed=seed)
    assert len(snap) < 0.003 * RATE
    assert share(snap, 2000, 15_000) > 0.7
    assert 2000 < spectrum(snap)[1].argmax() < 15_000


@pytest.mark.parametrize(
    ("voice", "low", "high"),
    [(POP, 200, 1500), (WHOOSH, 40, 1200), (STRIKE, 20, 900), (KNOCK, 60, 450), (CREAK, 250, 1200),
     (CRUNCH, 500, 9000)],
)  # fmt: skip
def test_each_voice_has_its_band(voice, low, high):
    assert share(sound(voice), low, high) > 0.7


@pytest.mark.parametrize("voice", ALL)
def test_a_voice_begins_and_ends_softly_and_is_of_level_one(voice):
    samples = sound(voice)
    assert np.isfinite(samples).all()
    assert abs(samples[0]) < 0.05
    assert abs(samples[-1]) < 0.05
    assert 0.1 < np.abs(samples).max() < 2.0
    assert (samples == sound(voice)).all()


def test_pitch_is_a_factor_on_all_frequencies():
    low, high = (spectrum(sound(KNOCK, pitch=pitch))[1].argmax() for pitch in (1.0, 1.1))
    assert high == pytest.approx(1.1 * low, rel=0.02)


def test_noise_is_white():
    state, samples = noise_seed(1, 2), np.empty(2**15)
    for k in range(len(samples)):
        state = next_noise(state)
        samples[k] = white(state)
    assert np.abs(samples).max() <= 1.0
    assert samples.mean() == pytest.approx(0.0, abs=0.01)
    assert samples.std() == pytest.approx(3**-0.5, rel=0.02)
    power = np.abs(np.fft.rfft(samples)) ** 2
    thirds = [part.mean() for part in np.array_split(power[1:], 3)]
    assert max(thirds) < 1.1 * min(thirds)
