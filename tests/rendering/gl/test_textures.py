"""Tileable noise, caustics and waves."""

import numpy as np
import pytest

from subsea.rendering.gl.textures import (
    caustics,
    cell_distance,
    halves,
    in_bytes,
    mipmapped,
    relief,
    ripples,
    tileable_noise,
)


def seam(texture):
    """Steps across the border over steps inside."""
    across = np.abs(texture[:, 0] - texture[:, -1]).mean() + np.abs(texture[0] - texture[-1]).mean()
    inside = np.abs(np.diff(texture, axis=1)).mean() + np.abs(np.diff(texture, axis=0)).mean()
    return across / inside


@pytest.mark.parametrize("make", [tileable_noise, caustics])
def test_edges_meet_and_seeds_differ(make):
    texture = make(1, 64)
    assert texture.shape == (64, 64)
    assert seam(texture) < 1.5
    np.testing.assert_array_equal(texture, make(1, 64))
    assert not np.allclose(texture, make(2, 64))


def test_noise_is_standardised():
    noise = tileable_noise(4, 128)
    assert abs(noise.mean()) < 1e-9
    assert noise.std() == pytest.approx(1.0)


def test_caustics_keep_the_light_and_gather_it_in_lines():
    light = caustics(1)
    assert light.mean() == pytest.approx(1.0)
    assert light.min() >= 0.0
    assert np.median(light) < 0.9  # most of the ground is darker than the mean
    assert np.quantile(light, 0.98) > 2.0


def test_longer_waves_gather_the_light_in_broader_lines():
    near, far = caustics(1), caustics(1, waves=(4.0, 14.0), reach=0.04, penumbra=0.01)
    wave = np.fft.fftfreq(256) * 256

    def finest(light):
        power = np.abs(np.fft.fft2(light - light.mean())) ** 2
        return (power * np.hypot(wave[:, None], wave[None, :])).sum() / power.sum()

    assert finest(far) < 0.6 * finest(near)
    assert far.mean() == pytest.approx(1.0)


def test_flat_water_leaves_the_light_as_it_is():
    np.testing.assert_allclose(caustics(1, 64, reach=0.0), 1.0, atol=1e-9)


def test_slopes_of_waves_are_those_of_one_surface_and_run_with_the_wind():
    x, y = ripples(3, 64)
    assert seam(x) < 1.5
    assert ((x**2 + y**2) / 2).mean() == pytest.approx(1.0)
    # A gradient field has no curl: kx·Y = ky·X for every wave.
    n = np.fft.fftfreq(64) * 64
    n[32] = 0.0  # the sign of the shortest wave is unknown
    curl = n[None, :] * np.fft.fft2(y) - n[:, None] * np.fft.fft2(x)
    curl[32] = curl[:, 32] = 0.0
    assert np.abs(curl).max() < 1e-6 * np.abs(np.fft.fft2(x)).max() * 64
    assert np.cov(x.ravel(), y.ravel())[0, 1] > 0.1  # the wind is between both axes


def test_the_relief_of_stone_meets_at_its_edges_and_knows_its_slopes():
    height, slope_x, slope_y, polyps = relief(5, 128)
    assert seam(height) < 1.5
    assert seam(polyps) < 1.5
    assert abs(height.mean()) < 1e-9
    assert polyps.min() == 0.0
    assert 0.8 < polyps.max() <= 1.0
    # Along a row the slopes add up to the change in height.
    np.testing.assert_allclose(
        (slope_x[:, 1:-1].cumsum(axis=1) / 128)[:, -1],
        (height[:, -1] + height[:, -2] - height[:, 0] - height[:, 1]) / 2,
    )
    assert slope_y.std() == pytest.approx(slope_x.std(), rel=0.3)


def test_no_place_is_far_from_the_nearest_point_of_its_cells():
    distance = cell_distance(3, 96, 12)
    assert 0.0 <= distance.min() < 0.1
    assert distance.max() < np.sqrt(2.0)
    assert seam(distance) < 1.5


def test_a_texture_keeps_its_values(context):
    values = np.arange(16.0).reshape(4, 4)
    texture = mipmapped(context, halves([values, 2 * values]))
    back = np.frombuffer(texture.read(), np.float16).reshape(4, 4, 2)
    np.testing.assert_array_equal(back[..., 1], 2 * values)
    texture.release()


def test_bytes_span_the_given_range():
    layers = [np.full((1, 1), value) for value in (-1.0, 0.0, 0.5, 7.0)]
    found = in_bytes(layers, np.full(4, -1.0), np.full(4, 1.0))
    assert found.ravel().tolist() == [0, 128, 191, 255]
