"""The seabed's triangles and the surface's disc."""

import numpy as np
import pytest

from subsea.rendering.sea.seabed import APRON_CM, CELLS, SKIRT_CM, drawn_height, surface, tiles
from subsea.rendering.sea.water import disc


@pytest.mark.parametrize("number", [9, 61, 193, 200])
def test_the_apron_goes_on_at_the_edge_height(number):
    heights = np.random.default_rng(0).uniform(-400, -300, (number, number))
    positions, slopes = surface(heights, 100.0)
    assert (len(positions) - 1) % CELLS == 0
    core = slice(CELLS, CELLS + number)
    np.testing.assert_allclose(positions[core, core, 2], heights)
    np.testing.assert_allclose(positions[0, core, 2], heights[0])
    assert positions[0, 0, 0] == -100.0 - CELLS * APRON_CM
    assert positions[-1, -1, 0] >= 100.0 + CELLS * APRON_CM
    np.testing.assert_allclose(slopes[core, : CELLS - 1, 0], 0.0, atol=1e-12)


def test_slopes_are_those_of_a_plane():
    axis = np.linspace(-100, 100, 9)
    x, y = np.meshgrid(axis, axis)
    _, slopes = surface(0.3 * x - 0.2 * y - 300, 100.0)
    inner = slopes[CELLS + 1 : CELLS + 8, CELLS + 1 : CELLS + 8]
    np.testing.assert_allclose(inner, np.broadcast_to([0.3, -0.2], inner.shape), atol=1e-9)


def test_every_level_covers_the_whole_ground_and_faces_up():
    axis = np.linspace(-100, 100, 25)
    positions, slopes = surface(np.broadcast_to(-300 + 0.2 * axis, (25, 25)), 100.0)
    width = positions[-1, -1, 0] - positions[0, 0, 0]
    found = tiles(positions, slopes)
    for level in range(3):
        area = 0.0
        for tile in found:
            corners = tile[level].vertices[:, :3].astype(np.float64)[tile[level].triangles]
            face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            assert (face[:, 2] > -1e-6).all()  # skirts hang straight down
            area += face[:, 2].sum() / 2
        np.testing.assert_allclose(area, width**2, rtol=1e-6)
    fine, middle, coarse = (len(shape.triangles) for shape in found[0])
    assert fine > 3 * middle > 6 * coarse


def test_skirts_hang_from_the_rim_outward():
    positions, slopes = surface(np.full((25, 25), -300.0), 100.0)
    shape = tiles(positions, slopes)[0][2]
    low = shape.vertices[:, 2] < -300.0 - 0.5 * SKIRT_CM
    assert low.sum() == 4 * (CELLS // 4)
    corners = shape.vertices[:, :3].astype(np.float64)[shape.triangles]
    hanging = low[shape.triangles].any(axis=1)
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[hanging]
    middle = shape.vertices[:, :3].mean(axis=0)
    outward = corners[hanging].mean(axis=1) - middle
    assert ((face * outward)[:, :2].sum(axis=1) > 0.0).all()


def test_the_disc_covers_the_unit_circle():
    places, triangles = disc(6, 200)
    a, b, c = np.moveaxis(places[triangles], 1, 0).astype(float)
    u, v = b - a, c - a
    area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2
    np.testing.assert_allclose(area, np.pi, rtol=1e-3)


def test_the_drawn_height_is_that_of_the_triangles():
    rng = np.random.default_rng(2)
    heights = rng.uniform(-400, -300, (9, 9))
    positions, _ = surface(heights, 100.0)
    shapes = [tile[0] for tile in tiles(positions, np.zeros_like(positions[..., :2]))]
    corners = np.concatenate(
        [
            shape.vertices[:, :3].astype(np.float64)[shape.triangles[: 2 * CELLS**2]]
            for shape in shapes
        ]
    )
    inside = (rng.dirichlet([1, 1, 1], len(corners))[:, :, None] * corners).sum(axis=1)
    inside = inside[np.abs(inside[:, :2]).max(axis=1) < 100.0]
    assert len(inside) == 2 * 8 * 8
    got = drawn_height(heights, 100.0, inside[:, 0], inside[:, 1])
    np.testing.assert_allclose(got, inside[:, 2])
