"""The flow about the hull against what a solid sphere must do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.habitat.current import BEAM_BL, WAVE_SPAN, add_bow_wave, bow_wave
from subsea.state import HULL_CM, Fishes, empty
from tests.support.scenes import everyone

RADIUS = 50.0
numbers = st.tuples(*[st.floats(-100, 100)] * 3).filter(lambda p: np.linalg.norm(p) > 1)


def _unit(p):
    return np.array(p) / np.linalg.norm(p)


@given(place=numbers, velocity=numbers)
def test_nothing_passes_the_surface(place, velocity):
    outward = _unit(place)
    flow = np.array(bow_wave(tuple(RADIUS * outward), velocity, RADIUS))
    assert flow @ outward == pytest.approx(np.dot(velocity, outward), abs=1e-9)


@given(place=numbers, velocity=numbers)
def test_the_flow_has_no_sources(place, velocity):
    """Its divergence is nil, by central differences."""
    p, h = 1.5 * RADIUS * _unit(place), 1e-3
    sum_of_slopes = 0.0
    for axis in range(3):
        step = h * np.eye(3)[axis]
        after, before = (bow_wave(tuple(q), velocity, RADIUS)[axis] for q in (p + step, p - step))
        sum_of_slopes += (after - before) / (2 * h)
    assert sum_of_slopes == pytest.approx(0, abs=1e-5)


def test_far_away_the_water_rests():
    wave = bow_wave((0.999 * WAVE_SPAN * RADIUS, 0.0, 0.0), (100.0, 0.0, 0.0), RADIUS)
    assert np.linalg.norm(wave) < 2
    assert bow_wave((1.001 * WAVE_SPAN * RADIUS, 0.0, 0.0), (100.0, 0.0, 0.0), RADIUS) == (0, 0, 0)


def test_a_fish_before_the_bow_is_pushed_aside_and_never_touched(make_sea):
    fishes = empty(Fishes, n=1)
    fishes.length[:] = 20.0
    fishes.position[:] = 0.0, 0.0, -300.0
    sea = make_sea()
    sea.submarine[:6] = -300.0, 3.0, -298.0, 120.0, 0.0, 0.0
    nearest = np.inf
    for _ in range(150):
        fishes.drift[:] = 0.0
        add_bow_wave(everyone(fishes), fishes, sea)
        fishes.position[:] += 0.033 * fishes.drift
        sea.submarine[:3] += 0.033 * sea.submarine[3:6]
        nearest = min(nearest, np.linalg.norm(fishes.position[0] - sea.submarine[:3]))
    assert sea.submarine[0] > 250  # it went right through where the fish was
    assert HULL_CM + BEAM_BL * 20.0 - 3.0 < nearest < HULL_CM + 20.0
