"""Shapes of formations: inside what fishes avoid, closed above the sand, correctly lit."""

from collections import OrderedDict
from itertools import pairwise

import numpy as np
import pytest

from subsea.base import disk_cache
from subsea.habitat.contact import clearances
from subsea.habitat.formations import RELIEF_CM, SHELL_CM, formations
from subsea.habitat.rocks import arch
from subsea.rendering.reef import rocks
from subsea.rendering.reef.rocks import (
    ABOVE,
    BURIED_CM,
    COARSEST_CM,
    COLUMNS,
    LEVELS,
    PIECE_CM,
    SKY,
    SUNNY,
    cut,
    shapes,
)
from subsea.scenario.schema import Arch


def floor(x, y):
    return -600.0 + 0.1 * x - 0.05 * y


NO_PILLARS, NO_ROCKS = np.zeros((0, 4)), np.zeros((0, 7))
PILLARS = np.array([[30.0, -20.0, 55.0, -250.0]])
ROCKS = np.array([[30.0, -20.0, -580.0, 60.0, 45.0, 40.0, 0.5], [90, 0, -570, 50, 60, 45, 0]])
ARCH = arch(Arch(position_cm=(0, 0), span_cm=300, height_cm=240), floor)
CASES = [(PILLARS, NO_ROCKS), (NO_PILLARS, ROCKS), (NO_PILLARS, ARCH)]


@pytest.fixture(scope="module", params=CASES, ids=["pillar", "rocks", "arch"])
def stone(request):
    """Pillars, rocks and the meshes of the one formation that they make."""
    pillars, rocks = request.param
    (levels,) = shapes(formations(pillars, rocks), floor)
    return pillars, rocks, levels


def test_what_is_avoided_is_never_thinner_than_what_is_drawn(stone):
    pillars, rocks, levels = stone
    for shape in levels:
        shown = shape.vertices[np.unique(shape.triangles)]
        far = clearances(pillars, rocks, shown[:, :3].astype(np.float64))
        assert far.max() < 0.0
        # Nor is it much thicker; a coarse mesh cuts corners.
        assert np.quantile(far, 0.05) > -SHELL_CM - RELIEF_CM - COARSEST_CM


def test_outside_is_where_normals_and_triangles_say(stone):
    for shape in stone[2]:
        corners = shape.vertices[:, :3].astype(np.float64)[shape.triangles]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = shape.vertices[:, 3:6]
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
        mean = normals[shape.triangles].mean(axis=1)
        assert ((facing * mean).sum(axis=1) > 0.0).mean() > 0.97


def test_each_level_has_fewer_triangles_and_goes_on_below_the_sand(stone):
    levels = stone[2]
    assert len(levels) == LEVELS
    numbers = [len(shape.triangles) for shape in levels]
    assert 1500 < numbers[0] < 12000
    for fine, coarse in pairwise(numbers):
        assert coarse < 0.35 * fine
    for shape in levels:
        assert shape.vertices.shape[1] == COLUMNS
        used = shape.vertices[np.unique(shape.triangles)]
        assert -6 * COARSEST_CM - BURIED_CM < used[:, ABOVE].min() < -0.3 * BURIED_CM


def test_the_sky_lights_the_top_and_the_sun_one_side():
    (levels,) = shapes(formations(NO_PILLARS, ARCH), floor)
    vertices = levels[0].vertices
    bow = vertices[vertices[:, ABOVE] > 250.0]
    top, roof = bow[bow[:, 5] > 0.8], bow[bow[:, 5] < -0.5]
    assert top[:, SKY].mean() > roof[:, SKY].mean() + 0.4
    assert top[:, SUNNY].mean() > 0.7
    assert roof[:, SUNNY].mean() < 0.1


def test_formations_shade_each_other():
    roof = np.array([[20.0, 10.0, -400.0, 200.0, 200.0, 40.0, 0.0]])
    alone, under = (
        shapes(formations(NO_PILLARS, rocks), floor)[0][0].vertices
        for rocks in (ROCKS, np.concatenate([ROCKS, roof]))
    )
    high = alone[:, ABOVE] > 20.0
    assert under[high, SKY].mean() < 0.7 * alone[high, SKY].mean()


def test_one_stone_stays_as_it_is():
    one, again = (shapes(formations(NO_PILLARS, ROCKS), floor)[0][0].vertices for _ in range(2))
    np.testing.assert_array_equal(one, again)


def test_pieces_cover_the_formation_at_every_level_and_overlap():
    (levels,) = shapes(formations(NO_PILLARS, ARCH), floor)
    pieces = cut(levels)
    assert len(pieces) > 4
    for k, whole in enumerate(levels):
        corners = whole.vertices[:, :3][whole.triangles].reshape(-1, 9)
        found = [piece[k].vertices[:, :3][piece[k].triangles].reshape(-1, 9) for piece in pieces]
        assert {*map(bytes, corners)} == {*map(bytes, np.concatenate(found))}
        assert len(corners) < sum(map(len, found)) < 2.5 * len(corners)
    wide = [np.ptp(piece[0].vertices[:, :3], axis=0).max() for piece in pieces]
    assert max(wide) < PIECE_CM + 5 * COARSEST_CM


def test_triangles_about_a_vertex_follow_each_other():
    """A renderer that remembers the last 256 vertices computes hardly any of them twice."""
    (levels,) = shapes(formations(NO_PILLARS, ARCH), floor)
    for piece in cut(levels):
        for shape in piece:
            corners = shape.triangles.ravel()
            remembered = np.full(256, -1)
            computed = 0
            for vertex in corners.tolist():
                computed += remembered[vertex % 256] != vertex
                remembered[vertex % 256] = vertex
            assert computed < 1.2 * len(np.unique(corners))


def test_a_small_stone_is_one_piece():
    (levels,) = shapes(formations(NO_PILLARS, ROCKS[:1]), floor)
    (piece,) = cut(levels)
    assert [len(shape.triangles) for shape in piece] == [len(shape.triangles) for shape in levels]


@pytest.mark.parametrize("axes", [(2, 2, 2), (6, 6, 6), (10, 10, 10), (100, 100, 5)])
def test_a_stone_however_thin_is_there_at_every_level(axes):
    rows = np.array([[0.0, 0.0, floor(0, 0) + 0.5 * axes[2], *axes, 0.3]])
    (levels,) = shapes(formations(NO_PILLARS, rows), floor)
    assert all(len(shape.triangles) for shape in levels)
    assert all(len(shape.triangles) for piece in cut(levels) for shape in piece)


def test_a_stone_under_the_sand_is_not_drawn():
    rows = np.array([[0.0, 0.0, floor(0, 0) - 200.0, 20.0, 20.0, 20.0, 0.0]])
    assert shapes(formations(NO_PILLARS, rows), floor) == []


def test_after_an_edit_only_the_stone_that_moved_is_shaped_again(monkeypatch):
    """With the same bits as without a memory."""
    far = [(900.0 * k, 0.0, -285.0, 40.0, 30.0, 28.0 + k, 0.5) for k in (-1, 0, 1)]
    before = np.array(far)
    after = before.copy()
    after[2, :2] += (31.0, -17.0)
    bed = np.full((61, 61), -300.0, np.float32), 1500.0
    drifted = bed[0].copy()
    drifted[30:32, 48:50] += 4.0  # sand about the third stone
    shaped = []

    def counted(*given):
        shaped.append(given[0])
        return make(*given)

    make = rocks._levels
    monkeypatch.setattr(disk_cache, "_remembered", OrderedDict())
    monkeypatch.setattr(rocks, "_levels", counted)
    rocks.pieces(*bed, NO_PILLARS, before, 12.0)
    assert len(shaped) == 3
    rocks.pieces(*bed, NO_PILLARS, before, 12.0)
    assert len(shaped) == 3
    moved = rocks.pieces(*bed, NO_PILLARS, after, 12.0)
    assert len(shaped) == 4
    monkeypatch.setattr(disk_cache, "_remembered", OrderedDict())
    alone = rocks.pieces(*bed, NO_PILLARS, after, 12.0)
    for levels, others in zip(moved, alone, strict=True):
        for mesh, other in zip(levels, others, strict=True):
            np.testing.assert_array_equal(mesh.vertices, other.vertices)
            np.testing.assert_array_equal(mesh.triangles, other.triangles)
    number = len(shaped)
    rocks.pieces(drifted, bed[1], NO_PILLARS, after, 12.0)
    assert len(shaped) == number + 1
