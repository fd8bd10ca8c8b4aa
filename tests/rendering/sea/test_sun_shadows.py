"""Maps of the distance to the sun: shadows lie where its rays end, on sand and on others."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.habitat.stone import sun_at
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.sea.sunlight import around, axes_of, map_of

SIZE = (320, 180)
FLAT = replace(PRESETS["medium"], smooth=False, snow=0, shafts=0, shadows=False, sun_map=0)
CAST = replace(FLAT, sun_map=512, fish_map=1024)
DEEP_CM = 60.0  # of the sand below a fish


@pytest.mark.parametrize("hour", [8.0, 12.0, 16.0])
def test_places_on_one_ray_of_the_sun_are_one_place_on_the_map(hour):
    sun = np.array(sun_at(hour)[0])
    axes = axes_of(sun)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-3)
    matrix = map_of(axes, np.array([10.0, 20.0, -300.0]), np.array([100.0, 50.0, 400.0]))
    rays = np.array([30.0, -10.0, -330.0]) + np.outer((0.0, 50.0, 120.0), sun)
    places = np.column_stack([rays, np.ones(3)]) @ matrix.T
    np.testing.assert_allclose(places[:, :2] - places[0, :2], 0.0, atol=1e-4)
    assert (np.diff(places[:, 2]) < 0.0).all()  # nearer to the sun


def test_the_map_holds_all_that_stands():
    axes = axes_of(np.array(sun_at(9.0)[0]))
    low, high = np.array([-300.0, -100.0, -600.0]), np.array([200.0, 700.0, -50.0])
    matrix = map_of(axes, *around(axes, low, high))
    corners = np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, 8).T
    places = np.column_stack([corners, np.ones(8)]) @ matrix.T
    assert np.abs(places[:, :3]).max() < 1.0


@pytest.fixture
def shade(drawn, scene):
    """Packet and hour -> grey levels (h, w) that the maps take from a picture of level sand."""

    def shade(packet, hour, **changed):
        level = replace(
            scene,
            terrain=np.full_like(scene.terrain, -300.0),
            water=replace_hour(scene.water, hour),
            **changed,
        )
        before, after = (drawn(packet, scene=level, quality=q) for q in (FLAT, CAST))
        return (before - after).sum(axis=2)

    return shade


def replace_hour(water, hour):
    """The water at another hour."""
    return type(water)(fog=water.fog, visibility_cm=water.visibility_cm, hour=hour)


def pixel(packet, place):
    """Row and column of a place in the picture."""
    (view,) = packet.views
    x, y, _, w = view.projection @ view.view @ (*place, 1.0)
    return (0.5 - 0.5 * y / w) * SIZE[1], (0.5 + 0.5 * x / w) * SIZE[0]


@pytest.mark.nightly
@pytest.mark.parametrize("hour", [9.0, 12.0, 15.0])
def test_the_shadow_of_a_fish_lies_where_the_sun_says(shade, make_packet, fish, hour):
    one = fish(0, (0.0, 0.0, DEEP_CM - 300.0))
    packet = make_packet([one], eye=(0.0, -30.0, -60.0), pitch=-1.3)
    dark = shade(packet, hour)
    row, column = np.unravel_index(dark.argmax(), dark.shape)
    sun = np.array(sun_at(hour)[0])
    expected = pixel(packet, np.array(one.position) - DEEP_CM / sun[2] * sun)
    assert dark.max() > 60
    np.testing.assert_allclose((row, column), expected, atol=12.0)
    # Elsewhere nothing changes.
    assert (np.abs(dark) > 6).mean() < 0.05


def test_the_maps_turn_to_the_sun_of_a_moving_clock(shade, make_packet, fish):
    one = fish(0, (0.0, 0.0, DEEP_CM - 300.0))
    packet = make_packet([one], eye=(0.0, -30.0, -60.0), pitch=-1.3)
    moved = shade(replace(packet, hour=15.0), 9.0)
    row, column = np.unravel_index(moved.argmax(), moved.shape)
    sun = np.array(sun_at(15.0)[0])
    expected = pixel(packet, np.array(one.position) - DEEP_CM / sun[2] * sun)
    np.testing.assert_allclose((row, column), expected, atol=12.0)


def test_one_fish_shades_another(shade, make_packet, fish):
    sun = np.array(sun_at(12.0)[0])
    low = np.array([0.0, 0.0, -240.0])
    high = low + 40.0 / sun[2] * sun
    pair = [fish(0, tuple(low)), fish(0, tuple(high), scale=2.0)]
    packet = make_packet(pair, eye=(0.0, -70.0, -215.0), pitch=-0.35)
    dark = shade(packet, 12.0)
    row, column = (round(x) for x in pixel(packet, low))
    assert dark[row - 8 : row + 9, column - 12 : column + 13].max() > 25


def test_stone_shades_a_fish(shade, make_packet, fish):
    """A boulder hangs between a fish and the sun; beside it the same fish is lit."""
    sun, found = np.array(sun_at(15.0)[0]), []
    for shift in (0.0, 150.0):
        low = np.array([0.0, 0.0, -240.0])
        stone = low + 110.0 / sun[2] * sun + (shift, 0.0, 0.0)
        rocks = np.array([[*stone, 40.0, 40.0, 30.0, 0.0]])
        packet = make_packet([fish(0, tuple(low))], eye=(0.0, -70.0, -215.0), pitch=-0.35)
        dark = shade(packet, 15.0, rocks=rocks)
        row, column = (round(x) for x in pixel(packet, low))
        found.append(dark[row - 8 : row + 9, column - 12 : column + 13].max())
    assert found[0] > 3.0 * found[1]
