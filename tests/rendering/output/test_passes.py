"""The parts of the light of a picture, against the picture and against other water."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.rendering.gl.id_buffer import SURFACE
from subsea.rendering.output.passes import LightParts
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.schema import Water
from tests.support.daily import only

HALF = 2.0**-11  # relative error of a half float
SIZE = 160, 90


@pytest.fixture
def packet(make_packet, fish):
    """Fishes at all levels of detail before sand, water and surface, with plankton."""
    fishes = [fish(0, (20, 90, -200), level=0), fish(1, (-30, 140, -190), level=2)]
    fishes += [fish(0, (60, 300, -180), level=4), fish(1, (-80, 400, -200), level=3, fade=0.5)]
    specks = np.random.default_rng(2).uniform((-90, 50, -230), (90, 200, -150), (300, 3))
    return make_packet(fishes, size=SIZE, pitch=0.25, plankton=specks.astype(np.float32))


@pytest.mark.parametrize("preset", only(["low"], ["low", "medium", "high"]))
def test_the_parts_add_up_to_the_picture(preset, make_renderer, packet):
    quality = replace(PRESETS[preset], floats=True)
    renderer = make_renderer(SIZE, quality=quality)
    renderer.draw(packet)
    picture, parts = renderer.light(), renderer.light_parts(packet)
    assert picture.std() > 0.02
    # The picture is rounded each time that something is blended over it.
    np.testing.assert_allclose(parts.light + parts.veil, picture, rtol=8 * HALF, atol=1e-4)
    assert 0.3 < parts.cover.mean() < 0.99
    assert parts.light.max() > 0.2


def test_a_picture_in_other_water_follows_from_the_parts(make_renderer, packet, scene):
    """Light of things does not depend on how far one sees: only what the water before them does."""
    found = {}
    for metres in (6, 12):
        water = Water(fog=(0.012, 0.115, 0.20), visibility_cm=100.0 * metres)
        renderer = make_renderer(SIZE, scene=replace(scene, water=water))
        renderer.draw(packet)
        found[metres] = renderer.light(), renderer.light_parts(packet)
    clear, murky = found[12][1], found[6][1]
    share = clear.transmittance
    subject = clear.subject(share)
    rebuilt = subject * murky.transmittance + murky.veil
    # The surface mirrors things in the water, too.
    solid = (clear.cover > 0.999) & (murky.cover > 0.999)
    solid &= renderer.id_maps(packet).kind != SURFACE
    assert solid.mean() > 0.1
    wrong = np.abs(rebuilt - found[6][0])[solid]
    assert np.quantile(wrong, 0.98) < 0.01
    # Beer's law: the share of the clear water squared is that of the murky one. Vertices have it.
    assert np.quantile(np.abs(share**2 - murky.transmittance)[solid], 0.95) < 0.01


def test_open_water_has_no_subject(make_renderer, make_packet):
    renderer = make_renderer(SIZE)
    renderer.draw(make_packet([], size=SIZE, pitch=-0.05, eye=(0.0, 0.0, -100.0)))
    parts = renderer.light_parts(make_packet([], size=SIZE, pitch=-0.05, eye=(0.0, 0.0, -100.0)))
    water = parts.cover == 0.0
    assert water.mean() > 0.05
    assert (parts.transmittance[water] == 0.0).all()
    assert (parts.subject(parts.transmittance)[water] == 0.0).all()


def test_cover_is_not_the_share_that_the_water_lets_through():
    light, clear = np.full((1, 1, 3), 0.06), np.full((1, 1, 3), 0.2)
    parts = LightParts(light, np.zeros((1, 1, 3)), clear, np.full((1, 1), 0.5))
    assert parts.transmittance == pytest.approx(0.4)  # of the half that is covered
    assert parts.subject(parts.transmittance) == pytest.approx(0.15)
