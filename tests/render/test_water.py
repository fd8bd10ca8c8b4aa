"""The open water, its surface and the shafts of light."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.render import Renderer
from subsea.render.quality import PRESETS
from subsea.render.water import disc, grid

PLAIN = replace(PRESETS["medium"], smooth=False, snow=0)


@pytest.fixture(scope="module")
def look(context, scene, make_packet):
    """Quality, eye and options of `make_packet` -> the picture of an empty sea, in grey levels."""
    bottomless = replace(scene, terrain=scene.terrain - np.float32(5000.0))
    renderer = Renderer(context, bottomless, (160, 90), PLAIN)

    def look(quality=PLAIN, **options):
        renderer.adapt(quality)
        renderer.draw(make_packet([], size=(160, 90), **options))
        return renderer.read_pixels().astype(float)

    yield look
    renderer.release()


def test_a_grid_covers_its_rectangle_once():
    triangles = grid(5, 3)
    corners = np.stack([triangles % 6, triangles // 6], axis=2)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    (u, v), (s, t) = (b - a).T, (c - a).T
    areas = (u * t - v * s) / 2
    np.testing.assert_array_equal(areas, 0.5)
    assert len(np.unique(corners.mean(axis=1).round(6), axis=0)) == 2 * 5 * 3


def test_the_rings_of_the_disc_reach_its_edge():
    places = disc(7, 24)
    assert np.linalg.norm(places, axis=2).max() == pytest.approx(1.0)
    assert np.linalg.norm(places, axis=2).min() == 0.0


def test_light_comes_from_above_and_the_deep_is_blue(look):
    up, level, down = (
        look(eye=(0, 0, -120), pitch=pitch).mean(axis=(0, 1)) for pitch in (1.2, 0.0, -0.6)
    )
    assert up.sum() > 1.5 * level.sum()
    assert level[2] > level[1] > level[0]
    assert level.sum() > down.sum()


def test_it_gets_darker_and_bluer_with_depth(look):
    shallow, deep = (look(eye=(0, 0, z)).mean(axis=(0, 1)) for z in (-500, -2500))
    assert deep.sum() < 0.85 * shallow.sum()
    assert deep[2] / deep[1] > shallow[2] / shallow[1]


def test_snells_window_has_the_size_that_refraction_gives_it(look):
    """Straight up the sky; beyond 48.6° of the vertical hardly any of it, whatever the depth."""
    for z in (-30.0, -150.0):
        straight, flat = (look(eye=(0, 0, z), pitch=pitch) for pitch in (np.pi / 2, 0.3))
        assert straight[40:50, 75:85].mean() > 1.4 * flat[:45].mean()


def test_shafts_move_in_the_light_and_are_gone_where_none_are_asked_for(look):
    none = replace(PLAIN, shafts=0)
    options = {"eye": (0, 0, -150), "pitch": 0.1, "heading": 0.55}
    with_shafts, without = look(PLAIN, **options), look(none, **options)
    assert np.abs(with_shafts - without).mean() > 0.5
    assert np.abs(with_shafts.mean() - without.mean()) < 3.0  # they add no light
    later = look(PLAIN, time_s=12.0, **options)
    assert np.abs(later - with_shafts)[:45].mean() > 0.5
    np.testing.assert_array_equal(look(none, **options), without)


def test_no_edge_of_the_surface_is_seen(look):
    """From the horizon up to 15° beyond it rows brighten little by little."""
    for z in (-300.0, -2000.0):
        rows = look(replace(PLAIN, shafts=0), eye=(0, 0, z), pitch=0.15)[:, 60:100].mean(axis=1)
        assert np.abs(np.diff(rows[30:65], axis=0)).max() < 6.0
