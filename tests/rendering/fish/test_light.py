"""Fishes are lit by the water around them."""

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from subsea.rendering.output.quality import PRESETS
from subsea.scenario.schema import LUMINANCE

FLANK = slice(84, 98), slice(130, 190)  # rows and columns of the picture


def luminance(picture):
    """Mean linear luminance of the middle of a picture."""
    share = np.asarray(picture)[FLANK] / 255.0
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return float((light @ LUMINANCE).mean())


@pytest.mark.nightly
def test_both_flanks_are_lit_and_silver_does_not_glow(drawn, scene, make_packet, fish):
    """In the morning the sun is behind the fish, in the afternoon behind the eye, or vice versa."""
    fusilier = scene.species[0]
    pale = dict.fromkeys(("back", "flank", "belly"), (0.7, 0.7, 0.7))
    skin = structs.replace(fusilier.skin, silver=0.0, patches=(), scales=0.0, **pale)
    packet = make_packet([fish(0, (17.0, 0.0, -200.0), np.pi / 2)], heading=0.0)
    shown = {}
    for silver in (0.0, 1.0):
        one = structs.replace(fusilier, skin=structs.replace(skin, silver=silver))
        for hour in (8.0, 16.0):
            water = structs.replace(scene.water, hour=hour)
            sea = replace(scene, species=(one, scene.species[1]), water=water)
            shown[silver, hour] = luminance(drawn(packet, scene=sea, quality=PRESETS["low"]))
    dark, lit = sorted(shown[0.0, hour] for hour in (8.0, 16.0))
    assert dark > 0.4 * lit
    assert shown[1.0, 8.0] + shown[1.0, 16.0] < 0.45 * (dark + lit)
