"""The seabed's triangles and the surface's disc."""

import numpy as np

from subsea.render.seabed import APRON_CM, FINEST_CELL_CM, drawn_height, surface, thinned, tiles
from subsea.render.water import disc


def test_the_apron_goes_on_at_the_edge_height():
    heights = np.random.default_rng(0).uniform(-400, -300, (9, 9))
    positions, slopes = surface(heights, 100.0)
    rim = len(APRON_CM)
    np.testing.assert_allclose(positions[rim:-rim, rim:-rim, 2], heights)
    np.testing.assert_allclose(positions[0, rim:-rim, 2], heights[0])
    assert positions[0, 0, 0] == -100.0 - APRON_CM[-1]
    np.testing.assert_allclose(slopes[rim:-rim, :rim, 0], 0.0, atol=1e-12)


def test_slopes_are_those_of_a_plane():
    axis = np.linspace(-100, 100, 9)
    x, y = np.meshgrid(axis, axis)
    _, slopes = surface(0.3 * x - 0.2 * y - 300, 100.0)
    inner = slopes[len(APRON_CM) + 1 : -len(APRON_CM) - 1, len(APRON_CM) + 1 : -len(APRON_CM) - 1]
    np.testing.assert_allclose(inner, np.broadcast_to([0.3, -0.2], inner.shape), atol=1e-9)


def test_every_cell_lies_in_one_tile_and_faces_up():
    side = 30
    triangles, first = tiles(side)
    assert first[0] == 0
    assert first[-1] == len(triangles) == 2 * (side - 1) ** 2
    assert len({tuple(t) for t in np.sort(triangles, axis=1).tolist()}) == len(triangles)
    x, y = triangles % side, triangles // side
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    assert (area == 1).all()


def test_the_disc_covers_the_unit_circle():
    a, b, c = np.moveaxis(disc(6, 200), 1, 0).astype(float)
    u, v = b - a, c - a
    area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2
    np.testing.assert_allclose(area, np.pi, rtol=1e-3)


def test_a_fine_grid_is_thinned_and_keeps_its_corners():
    heights = np.random.default_rng(1).uniform(size=(193, 193))
    coarse = thinned(heights, 2080.0)
    assert coarse.shape == (97, 97)
    assert FINEST_CELL_CM <= 2 * 2080.0 / 96
    np.testing.assert_array_equal(coarse[[0, -1]][:, [0, -1]], heights[[0, -1]][:, [0, -1]])
    assert thinned(heights[:9, :9], 2080.0).shape == (9, 9)


def test_the_drawn_height_is_that_of_the_triangles():
    rng = np.random.default_rng(2)
    heights = rng.uniform(-400, -300, (9, 9))
    positions, _ = surface(heights, 100.0)
    corners = positions.reshape(-1, 3)[tiles(len(positions))[0]]
    inside = (rng.dirichlet([1, 1, 1], len(corners))[:, :, None] * corners).sum(axis=1)
    inside = inside[np.abs(inside[:, :2]).max(axis=1) < 100.0]
    assert len(inside) == 2 * 8 * 8
    got = drawn_height(heights, 100.0, inside[:, 0], inside[:, 1])
    np.testing.assert_allclose(got, inside[:, 2])
