"""Pictures gather light, and are developed once."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.rendering.output.quality import PRESETS

SIZE = 160, 90


def test_an_exposure_is_the_mean_of_light(make_renderer, make_packet, fish):
    renderer = make_renderer(SIZE)
    packets = [make_packet([fish(0, (x, 60, -200))], size=SIZE) for x in (-10, 25)]
    seen = []
    for packet in packets:
        renderer.draw(packet)
        seen.append(renderer.light())
    assert np.abs(seen[0] - seen[1]).max() > 0.05
    with pytest.raises(ValueError, match="nothing has been exposed"):
        renderer.show_exposure()
    for _ in range(2):  # the first begins again
        for number, packet in enumerate(packets):
            renderer.expose(packet, first=number == 0)
            renderer.show_exposure()
            mean = np.mean(seen[: number + 1], axis=0)
            np.testing.assert_allclose(renderer.light(), mean, rtol=2e-3, atol=1e-4)


@pytest.mark.parametrize("preset", ["low", "high"])
def test_two_of_one_picture_are_that_picture(preset, make_renderer, make_packet, fish):
    renderer = make_renderer(SIZE, quality=replace(PRESETS[preset], smooth=False))
    packet = make_packet([fish(0, (0, 60, -200))], size=SIZE)
    renderer.draw(packet)
    once = renderer.read_pixels().astype(int)
    for number in range(2):
        renderer.expose(packet, first=number == 0)
    renderer.show_exposure()
    assert np.abs(renderer.read_pixels().astype(int) - once).max() <= 1


def test_smoothing_by_contrast_leaves_bubbles_round(make_renderer, make_packet, fish):
    """It would make crosses of them. Samples have smoothed the edges before."""
    pictures = []
    packet = make_packet([fish(0, (0, 60, -200))], size=SIZE)
    for smooth in (False, True):
        renderer = make_renderer(SIZE, quality=replace(PRESETS["high"], smooth=smooth))
        renderer.expose(packet, first=True)
        renderer.show_exposure()
        pictures.append(renderer.read_pixels())
    np.testing.assert_array_equal(*pictures)
