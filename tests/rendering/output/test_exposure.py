"""Pictures gather light, and are developed once."""

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
    for packet in packets:
        renderer.expose(packet)
    renderer.show_exposure()
    np.testing.assert_allclose(renderer.light(), np.mean(seen, axis=0), rtol=2e-3, atol=1e-4)
    with pytest.raises(ValueError, match="nothing has been exposed"):
        renderer.show_exposure()


@pytest.mark.parametrize("preset", ["low", "high"])
def test_two_of_one_picture_are_that_picture(preset, make_renderer, make_packet, fish):
    renderer = make_renderer(SIZE, quality=PRESETS[preset])
    packet = make_packet([fish(0, (0, 60, -200))], size=SIZE)
    renderer.draw(packet)
    once = renderer.read_pixels().astype(int)
    for _ in range(2):
        renderer.expose(packet)
    renderer.show_exposure()
    assert np.abs(renderer.read_pixels().astype(int) - once).max() <= 1
