"""Meshes of patches: cut at lines, and laid where a patch is adjusted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.view.adjustment import PatchAdjustment, homography, moved
from subsea.view.meshes import (
    fine_mesh,
    grid_triangles,
    lit_places,
    shown_size,
    subdivided,
    unmoved,
)
from subsea.view.rig import DisplayPatch, Projection, Warp, sources_at

PLACE = (10, 20, 400, 300)
CORNERS = np.array([[0.02, -0.01], [0.97, 0.03], [1.01, 0.98], [0.0, 1.02]])


def woven(bend, columns=5, rows=4):
    """A warp of a grid of places whose sources are bent."""
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    u, v = x + bend * np.sin(np.pi * y) * 0.2, y
    vertices = np.stack([x, y, u, v, u, v], axis=-1).reshape(-1, 6).astype(np.float32)
    return Warp(vertices, grid_triangles(columns, rows).astype(np.int32))


@given(st.integers(1, 9), st.integers(1, 5), st.floats(-0.3, 0.3))
@pytest.mark.parametrize("columns", [(0, 1), (2, 3)])
def test_a_divided_mesh_shows_the_same_with_smaller_triangles(columns, across, up, bend):
    points = np.random.default_rng(6).uniform(0.01, 0.99, (30, 2))
    warp = woven(bend)
    fine = subdivided(warp, across, up, columns)
    np.testing.assert_allclose(sources_at(fine, points), sources_at(warp, points), atol=1e-5)
    values = fine.vertices[fine.triangles][..., columns]
    cells = values * [across, up]
    crossed = np.floor(cells.max(axis=1) - 1e-4) > np.floor(cells.min(axis=1) + 1e-4)
    inside = ((values > 0.0) & (values < 1.0)).all(axis=(1, 2))
    assert not crossed[inside].any()


def test_a_mesh_of_one_cell_is_not_cut():
    warp = woven(0.2)
    for one, other in zip(subdivided(warp, 1, 1), warp, strict=True):
        np.testing.assert_array_equal(one, other)


def patch(**changes):
    return DisplayPatch(PLACE, PLACE, PLACE, **changes)


def test_a_patch_that_is_not_adjusted_keeps_its_mesh():
    assert fine_mesh(patch()) is None
    assert fine_mesh(patch(adjustment=PatchAdjustment(gain=(0.5, 1.0, 1.0)))) is None
    warp = woven(0.1)
    assert fine_mesh(patch(warp=warp)) is warp
    lit = lit_places(patch(warp=warp), warp)
    np.testing.assert_array_equal(lit[:, :2], warp.vertices[:, :2])
    assert (lit[:, 2] == 1.0).all()


def test_a_mesh_is_cut_until_it_follows_the_field_of_its_points():
    points = np.zeros((4, 4, 2))
    points[1, 2] = 20 / 400, -12 / 300
    adjustment = PatchAdjustment(homography(CORNERS), points)
    for warp in (None, woven(0.1)):
        one = patch(warp=warp, adjustment=adjustment)
        mesh = fine_mesh(one)
        lit = lit_places(one, mesh)
        placed = Warp(
            np.hstack([mesh.vertices[:, :2], np.tile(lit[:, :2] / lit[:, 2:], 2)]), mesh.triangles
        )
        at = np.random.default_rng(2).uniform(0.01, 0.99, (60, 2))
        wanted = moved(adjustment, at)
        away = sources_at(placed, at) - wanted[:, :2] / wanted[:, 2:]
        assert np.abs(away * PLACE[2:]).max() < 0.2  # pixels


@pytest.mark.parametrize("turns", [0, 1])
def test_a_dome_without_a_mesh_of_its_own_keeps_its_square(turns):
    turn = np.linalg.matrix_power(np.array([[0.0, 1, 0], [-1, 0, 1], [0, 0, 1]]), turns)
    one = patch(shape=Projection.DOME, adjustment=PatchAdjustment(homography(CORNERS), turn=turn))
    assert shown_size(one) == ((400, 300) if turns == 0 else (300, 400))
    sources = sources_at(fine_mesh(one), np.array([[0.5, 0.5], [1.0, 0.5], [0.5, 1.0]]))
    wanted = [[0.5, 0.5], [7 / 6, 0.5], [0.5, 1.0]]
    if turns == 1:
        wanted = [[0.5, 0.5], [1.0, 0.5], [0.5, 7 / 6]]
    np.testing.assert_allclose(sources, wanted, atol=1e-6)


def test_a_place_is_found_from_where_it_is_lit():
    assert tuple(unmoved(patch(), (0.3, 0.6))) == (0.3, 0.6)
    mirror = np.array([[-1.0, 0, 1], [0, 1, 0], [0, 0, 1]])
    adjustment = PatchAdjustment(homography(CORNERS), turn=mirror)
    x, y, w = moved(adjustment, np.array([[0.3, 0.6]]))[0]
    found = unmoved(patch(adjustment=adjustment), (x / w, y / w))
    assert found == pytest.approx([0.3, 0.6], abs=0.01)  # the inverse is linear in each triangle
