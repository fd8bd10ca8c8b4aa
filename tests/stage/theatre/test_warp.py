"""Warps of grids and meshes: what they show, how coarse they may be, what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.stage.theatre.warp import (
    describe_warp,
    from_grid,
    is_mirrored,
    mesh,
    rasterized,
    validated,
)
from subsea.view.rig import sources_at

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
SIZE = (64, 48)


def pixels(size):
    x, y = (np.arange(size[0]) + 0.5) / size[0], 1 - (np.arange(size[1]) + 0.5) / size[1]
    return np.stack(np.meshgrid(x, y), axis=-1)


def bent(points, bend):
    """A smooth map of the square onto a part of itself."""
    x, y = np.moveaxis(points, -1, 0)
    u = 0.1 + 0.8 * x + bend * np.sin(np.pi * y) * x * (1 - x)
    return np.stack([u, 0.1 + 0.8 * y - bend * np.sin(np.pi * x) * y * (1 - y)], axis=-1)


def test_a_straight_grid_is_two_triangles_from_border_to_border():
    warp = validated(from_grid(pixels(SIZE), SIZE), "x")
    assert len(warp.triangles) == 2
    corners = warp.vertices[np.lexsort(warp.vertices[:, :2].T)]
    np.testing.assert_allclose(corners[:, :2], [[0, 0], [1, 0], [0, 1], [1, 1]])
    np.testing.assert_allclose(corners[:, 2:4], corners[:, :2], atol=1e-6)
    np.testing.assert_array_equal(corners[:, 4:], corners[:, 2:4])
    assert not is_mirrored(warp)
    assert describe_warp(warp) == "a mesh of 2 triangles, 100% lit"


@given(st.floats(-0.3, 0.3), st.integers(0, 2**32 - 1))
def test_a_coarse_mesh_misses_no_point_by_a_quarter_of_a_pixel(bend, seed):
    size = (240, 160)
    warp = validated(from_grid(bent(pixels(size), bend), size), "x")
    assert len(warp.triangles) < 3000
    points = np.random.default_rng(seed).uniform(0.01, 0.99, (40, 2))
    away = (sources_at(warp, points) - bent(points, bend)) * size
    assert np.linalg.norm(away, axis=1).max() < 0.25


def woven(bend, columns=13, rows=9):
    """The bent map as a mesh whose triangles meet corner to corner."""
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    places = np.stack([x, y], axis=-1).reshape(-1, 2)
    k = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.stack([k, k + 1, k + columns + 1], axis=1)
    upper = np.stack([k, k + columns + 1, k + columns], axis=1)
    return validated(mesh(places, bent(places, bend), np.vstack([lower, upper])), "x")


@given(st.floats(-0.3, 0.3), st.integers(0, 2**32 - 1))
def test_there_and_back_again(making, bend, seed):
    warp = woven(bend)
    points = np.random.default_rng(seed).uniform(0.0, 1.0, (30, 2))
    for eye in (0, 1):
        back = making.places_of(warp, sources_at(warp, points, eye), eye)
        np.testing.assert_allclose(back, points, atol=1e-4)
    assert np.isnan(making.places_of(warp, np.array([[0.01, 0.01]]))).all()


@given(st.floats(-0.3, 0.3), st.integers(0, 2**32 - 1))
def test_a_coarse_mesh_leads_there_and_back_within_its_tolerance(making, bend, seed):
    warp = validated(from_grid(bent(pixels(SIZE), bend), SIZE), "x")
    points = np.random.default_rng(seed).uniform(0.01, 0.99, (30, 2))
    away = np.linalg.norm(
        (making.places_of(warp, sources_at(warp, points)) - points) * SIZE, axis=1
    )
    assert np.nanmax(away) < 0.5
    assert np.isnan(away).sum() <= 1  # seams between fine and coarse blocks, in the picture


@pytest.mark.parametrize("none", [np.nan, np.inf, -np.inf, -1.0, 1e30, 0.0])
def test_cells_that_touch_a_point_that_is_none_stay_dark(none):
    grid = pixels(SIZE)
    grid[10:20, 30:40] = none
    warp = validated(from_grid(grid, SIZE), "x")
    points = pixels(SIZE).reshape(-1, 2)
    found = sources_at(warp, points).reshape(grid.shape)
    dark = np.isnan(found[..., 0])
    assert dark[10:20, 30:40].all()
    dark[9:21, 29:41] = False
    assert not dark.any()
    np.testing.assert_allclose(found[~np.isnan(found)], pixels(SIZE)[~np.isnan(found)], atol=1e-5)


def test_a_signalling_nan_is_no_point_either():
    grid = pixels(SIZE).astype(np.float32)
    grid[3, 3].view(np.uint32)[:] = 0x7F800001
    assert len(validated(from_grid(grid, SIZE), "x").triangles) > 2


def test_a_mesh_is_cut_where_it_leaves_the_picture():
    warp = validated(mesh(SQUARE, SQUARE * 1.25 - 0.125, TWO), "x")
    assert warp.vertices[:, 2:].min() >= 0
    assert warp.vertices[:, 2:].max() <= 1
    points = np.random.default_rng(3).uniform(0, 1, (300, 2))
    wanted = points * 1.25 - 0.125
    found = sources_at(warp, points)
    inside = ((wanted > 1e-3) & (wanted < 0.999)).all(axis=1)
    outside = ((wanted < -1e-3) | (wanted > 1.001)).any(axis=1)
    assert inside.sum() > 100
    assert outside.sum() > 50
    np.testing.assert_allclose(found[inside], wanted[inside], atol=1e-5)
    assert np.isnan(found[outside]).all()


def test_rounding_beyond_the_picture_is_moved_in():
    warp = validated(mesh(SQUARE, SQUARE * 1.0002 - 0.0001, TWO), "x")
    assert len(warp.triangles) == 2
    assert (warp.vertices[:, 2:].min(), warp.vertices[:, 2:].max()) == (0, 1)


FAN = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
MIDDLE = np.vstack([SQUARE, [[0.5, 0.5]]])


@pytest.mark.parametrize(
    ("places", "sources", "triangles", "said"),
    [
        (SQUARE, SQUARE, np.empty((0, 3)), "an empty mesh"),
        (SQUARE * np.nan, SQUARE, TWO, "4 of 4 points of its mesh are nowhere near"),
        (SQUARE, SQUARE * 1e300, TWO, "3 of 4 points of its mesh are nowhere near"),
        (SQUARE, SQUARE * [1920, 1200], TWO, "3 of 4 points have u or v outside 0 to 1"),
        (SQUARE * [1, 0], SQUARE, TWO, "2 of 2 triangles have no area"),
        (SQUARE + 2, SQUARE, TWO, "none of its 2 triangles lies on the projector"),
        (MIDDLE, np.vstack([SQUARE / 2, [[0.25, 0.7]]]), FAN, "1 of 4 triangles are folded"),
    ],
)
def test_errors_name_the_number_of_faulty_points(places, sources, triangles, said):
    with pytest.raises(UserError, match=said) as caught:
        validated(mesh(places, sources, triangles), "left.obj")
    assert str(caught.value).startswith("left.obj: ")


def test_a_wrinkle_at_the_rim_of_a_measurement_is_let_pass():
    grid = pixels((100, 100))
    grid[0, 0], grid[0, 1] = grid[0, 1].copy(), grid[0, 0].copy()
    assert len(validated(from_grid(grid, (100, 100)), "x").triangles) > 2


def test_a_mirrored_picture_is_reported():
    warp = validated(mesh(SQUARE, SQUARE * [1, -1] + [0, 1], TWO), "x")
    assert is_mirrored(warp)
    assert describe_warp(warp).endswith(", mirrored")
    turned = validated(mesh(SQUARE, 1 - SQUARE, TWO), "x")
    assert not is_mirrored(turned)


def test_values_are_painted_over_the_pixels():
    warp = mesh(SQUARE, SQUARE, TWO)
    picture = rasterized(warp, SQUARE @ [0.25, 0.5], (40, 20))
    np.testing.assert_allclose(picture, pixels((40, 20)) @ [0.25, 0.5], atol=1e-6)
    half = rasterized(mesh(SQUARE * [0.5, 1], SQUARE, TWO), np.ones(4), (40, 20))
    assert (half[:, :20] == 1).all()
    assert (half[:, 20:] == 0).all()
