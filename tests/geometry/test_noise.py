"""Noise that is smooth, even and the same everywhere."""

import numpy as np
import pytest

from subsea.geometry.noise import fractal, noise


def test_it_is_0_on_the_lattice_and_smooth_between():
    assert noise(3.0, -4.0, 5.0) == 0.0
    for p in np.random.default_rng(1).uniform(-50, 50, (200, 3)):
        step = 1e-5
        ahead, behind = noise(p[0] + step, p[1], p[2]), noise(p[0] - step, p[1], p[2])
        assert abs(ahead - behind) < 2 * step * 6.0


def test_it_is_about_0_and_seldom_large():
    places = np.random.default_rng(2).uniform(-500, 500, (5000, 3))
    values = np.array([noise(*p) for p in places])
    assert abs(values.mean()) < 0.02
    assert 0.15 < values.std() < 0.35
    assert np.abs(values).max() < 1.2
    many = np.array([fractal(*p, 3) for p in places])
    assert many.std() > values.std()


def test_distant_places_have_nothing_in_common():
    places = np.random.default_rng(3).uniform(0, 40, (3000, 3))
    one, other = ([noise(*p) for p in places + shift] for shift in (0.0, 256.0))
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.1


def test_one_octave_is_the_noise_itself():
    assert fractal(1.3, 2.7, -0.4, 1) == pytest.approx(noise(1.3, 2.7, -0.4))
