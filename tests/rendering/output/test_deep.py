"""Finished pictures of 16 bits."""

from dataclasses import replace

import numpy as np

from subsea.rendering.output.quality import PRESETS

SIZE = 160, 90


def test_a_deep_picture_is_the_same_with_more_levels(make_renderer, make_packet, fish):
    packet = make_packet([fish(0, (0, 60, -200))], size=SIZE, pitch=0.2)
    pictures = []
    for deep in (False, True):
        renderer = make_renderer(SIZE, quality=replace(PRESETS["medium"], deep=deep))
        renderer.draw(packet)
        pictures.append(renderer.read_pixels())
    plain, deep = pictures
    assert (plain.dtype, deep.dtype) == (np.uint8, np.uint16)
    assert np.abs(deep / 257.0 - plain).max() < 1.6  # both have a little noise of their own
    assert len(np.unique(deep)) > 4 * len(np.unique(plain))
