"""Stone at arm's length: four triangles for one, no gaps, and nearer to the drawn surface."""

import numpy as np
import pytest

from subsea.habitat.formations import formations, on_the_surface
from subsea.rendering.gl.static_batch import StaticMesh
from subsea.rendering.reef.fine_stone import finer, halved
from subsea.rendering.reef.rocks import shapes

NO_PILLARS = np.zeros((0, 4))
ROWS = np.array([
    [0.0, 0.0, -220.0, 180.0, 150.0, 110.0, 0.4], [2000.0, 0.0, -250.0, 60.0, 50.0, 40.0, 0.0],
])  # fmt: skip


@pytest.fixture(scope="module")
def blocks():
    return formations(NO_PILLARS, ROWS)


@pytest.fixture(scope="module")
def stone(blocks):
    (levels, _) = shapes(blocks, lambda x, y: np.full(np.shape(x), -300.0))
    return levels[0]


def directed_sides(triangles):
    return [
        (int(a), int(b))
        for row in triangles
        for a, b in zip(row, np.roll(row, -1), strict=True)
    ]  # fmt: skip


def test_each_triangle_becomes_four_that_share_their_sides():
    quad = StaticMesh(
        np.float32([[0, 0, 0, 1], [2, 0, 0, 3], [2, 2, 0, 5], [0, 2, 0, 7]]),
        np.int32([[0, 1, 2], [0, 2, 3]]),
    )
    parts = halved(quad)
    assert len(parts.triangles) == 8 and len(parts.ends) == 5
    np.testing.assert_array_equal(parts.rough[:4], quad.vertices)
    corners = parts.rough[:, :3][parts.triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(across, np.tile([0.0, 0.0, 1.0], (8, 1)))  # same side, same area
    sides = directed_sides(parts.triangles)
    assert len(set(sides)) == len(sides)  # each of two triangles runs it in its own direction
    alone = [side for side in sides if side[::-1] not in set(sides)]
    assert len(alone) == 8  # the outline of the square, halved
    for (a, b), vertex in zip(parts.ends, parts.rough[4:], strict=True):
        np.testing.assert_allclose(vertex, (quad.vertices[a] + quad.vertices[b]) / 2.0)


def test_new_vertices_lie_on_the_drawn_stone(stone, blocks):
    parts = halved(stone)
    first = len(stone.vertices)
    fine = finer(parts, blocks[::-1]).vertices
    assert fine.shape == parts.rough.shape
    np.testing.assert_array_equal(fine[:first], stone.vertices)
    rough_cm, fine_cm = (
        on_the_surface(blocks[0], part[first:, :3].astype(np.float64), 0)[2]
        for part in (parts.rough, fine)
    )
    assert np.quantile(fine_cm, 0.9) < 0.2 * np.quantile(rough_cm, 0.9)
    np.testing.assert_allclose(np.linalg.norm(fine[first:, 3:6], axis=1), 1.0, atol=1e-3)
    np.testing.assert_allclose(fine[first:, 6:], parts.rough[first:, 6:])  # light and growth


def test_a_piece_without_triangles_stays_without():
    nothing = StaticMesh(np.zeros((0, 13), np.float32), np.zeros((0, 3), np.int32))
    parts = halved(nothing)
    assert len(parts.triangles) == 0 and finer(parts, []).vertices.shape == (0, 13)
