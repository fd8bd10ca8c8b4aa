"""The normal map of scales, and its tangents on the mesh of a fish."""

import numpy as np
import pytest

from subsea.export.clips import Model
from subsea.export.scale_relief import SCALES, scale_normals, tangents
from subsea.fish.sheet_layout import BODY, borders
from subsea.fish.species import load_species


def test_scales_lie_on_the_flank_and_not_on_face_and_fins() -> None:
    species = load_species("fusilier")
    relief = scale_normals(species)
    assert relief is not None
    normal = relief / 127.5 - 1.0
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1.0, atol=0.02)
    height, width = relief.shape[:2]
    steep = np.hypot(normal[..., 0], normal[..., 1])
    middle = slice(round(0.35 * BODY.top * height), round(0.65 * BODY.top * height))
    first, last = borders(species.surface)

    def column(x: float) -> int:
        return int((x - first) / (last - first) * width)

    flank = steep[middle, column(0.35) : column(0.6)]
    assert 0.1 < flank.mean() < 0.3 and flank.max() < 0.45
    assert steep[middle, : column(species.surface.eye.at)].max() < 0.01
    assert steep[round(BODY.top * height) :].max() < 0.01  # fins
    assert steep[:, column(species.surface.tail.begin + 0.07) :].max() < 0.01
    # As many scales along the flank as in the dive: each slopes from its front to its rear.
    row = normal[middle, column(0.3) : column(0.65), 0][3]
    seams = (np.diff(row) < -0.15).sum()
    assert seams == pytest.approx(0.35 * SCALES[0], abs=4)


def test_rays_and_fishes_without_scales_have_none() -> None:
    for name in ("spotted_eagle_ray",):
        assert scale_normals(load_species(name)) is None


def test_tangents_point_to_the_tail_and_the_other_axis_up(model: Model) -> None:
    """Both flanks show the same picture, mirrored: the sign differs."""
    ways = tangents(model.rest, model.normals, model.uv, model.triangles)
    np.testing.assert_allclose(np.linalg.norm(ways[:, :3], axis=1), 1.0, atol=1e-6)
    assert np.abs((ways[:, :3] * model.normals).sum(axis=1)).max() < 1e-6
    if model.scales is None:
        return
    z = model.rest[: model.solid, 2]
    flank = np.abs(model.normals[: model.solid, 2]) > 0.8
    assert (ways[: model.solid][flank, 0] < -0.8).mean() > 0.98
    for side in (-1.0, 1.0):
        own = ways[: model.solid][flank & (np.sign(z) == side)]
        normal = model.normals[: model.solid][flank & (np.sign(z) == side)]
        up = np.cross(normal, own[:, :3]) * own[:, 3:]
        assert (up[:, 1] > 0.5).mean() > 0.97
        assert (own[:, 3] == -side).mean() > 0.97


def test_a_plain_square_has_the_axes_of_its_map() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    normals = np.tile([0, 0, 1.0], (4, 1))
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    for uv, way, sign in (
        (points[:, :2], (1, 0, 0), 1.0),
        (points[:, :2] * (-1, 1) + (1, 0), (-1, 0, 0), -1.0),
        (points[:, [1, 0]], (0, 1, 0), -1.0),
    ):
        np.testing.assert_allclose(
            tangents(points, normals, uv, triangles), np.tile((*way, sign), (4, 1)), atol=1e-12
        )
