"""Sand, stone, corals and seaweed against the renderer's own meshes."""

import numpy as np
import pytest

from subsea.dive.start import start_world
from subsea.export.scene import GROUPS, SceneMesh
from subsea.export.statics import StillMoment, moment_of, static_meshes
from subsea.habitat.seaweed import KINDS
from subsea.rendering.reef.coral import bake
from subsea.world.world import World
from tests.support.scenes import BARE

TABLES = """
[[reef]]
position_cm = [-50.0, 150.0]
spread_cm = 250.0
number = 60
"""
SEAWEED = """
[[seaweed]]
kind = "{}"
position_cm = [-250.0, -200.0]
spread_cm = 60.0
clusters = 2
"""


@pytest.fixture(scope="module")
def sea(tmp_path_factory: pytest.TempPathFactory) -> World:
    """A small sea with a rock, some growths and seaweed."""
    file = tmp_path_factory.mktemp("sea") / "grown.toml"
    file.write_text(BARE.read_text() + TABLES + "".join(map(SEAWEED.format, KINDS)))
    return start_world(str(file))


def meshes(sea: World, group: str, detail: int = 1) -> list[SceneMesh]:
    return static_meshes(sea, (group,), detail, moment_of(sea, 1.0, np.array([0.0, 0, -200.0])))


def world_points(mesh: SceneMesh, place: np.ndarray) -> np.ndarray:
    return np.asarray(mesh.points @ place[:3, :3].T + place[:3, 3])


@pytest.mark.parametrize("group", GROUPS)
def test_meshes_are_whole(sea: World, group: str) -> None:
    found = meshes(sea, group)
    assert found and len({one.name for one in found}) == len(found)
    for one in found:
        assert one.group == group
        np.testing.assert_allclose(np.linalg.norm(one.normals, axis=1), 1.0, atol=1e-3)
        assert one.triangles.min() == 0 and one.triangles.max() < len(one.points)
        assert (one.colors >= 0.0).all() and one.colors.max() <= 1.0
        assert len(one.tints) == len(one.places)
        a, b, c = (one.points[one.triangles[:, k]] for k in range(3))
        facing = (np.cross(b - a, c - a) * one.normals[one.triangles].sum(axis=1)).sum(axis=1)
        assert (facing >= 0.0).mean() > 0.85


def test_the_sand_lies_where_fishes_feel_it(sea: World) -> None:
    (sand,) = meshes(sea, "sand")
    bed, half = sea.state.sea.heights, sea.state.sea.half_width
    inside = (np.abs(sand.points[:, :2]) <= half + 0.01).all(axis=1)
    assert inside.sum() == bed.size
    np.testing.assert_allclose(sand.points[inside, 2], bed.ravel(), atol=0.01)
    assert np.abs(sand.points[:, :2]).max() > half + 1000.0  # the apron


def test_growths_are_where_the_renderer_draws_them(sea: World) -> None:
    """Each once, at its place, in its colour: as `coral.bake` makes them."""
    reef = sea.state.reef
    drawn = [levels[2].vertices for levels in bake(reef)]
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for mesh in meshes(sea, "corals"):
        for place, tint in zip(mesh.places, mesh.tints, strict=True):
            found.append((world_points(mesh, place), mesh.colors * tint))
    assert len(found) == len(drawn) == len(reef.kind) > 30
    middles = np.array([points.mean(axis=0) for points, _ in found])
    off = []
    for vertices in drawn:
        near = int(np.linalg.norm(middles - vertices[:, :3].mean(axis=0), axis=1).argmin())
        points, colours = found[near]
        np.testing.assert_allclose(points, vertices[:, :3], atol=0.01)
        words = vertices.view(np.uint8)
        shown = (words[:, 16:19] / 255.0) ** 2 * (words[:, 23:24] / 255.0)
        off.append(np.abs(colours.mean(axis=0) - shown.mean(axis=0)).max())
    assert max(off) < 0.1  # a mesh of a kind has one pair of colours, the drawn ones differ
    assert np.mean(off) < 0.03


def test_stone_is_coarser_at_a_coarser_level(sea: World) -> None:
    fine, coarse = (meshes(sea, "stone", detail) for detail in (0, 2))
    assert len(fine) == len(coarse) > 0
    assert sum(len(m.points) for m in coarse) < 0.4 * sum(len(m.points) for m in fine)
    for one, other in zip(fine, coarse, strict=True):
        np.testing.assert_allclose(one.points.mean(axis=0), other.points.mean(axis=0), atol=60.0)


def test_seaweed_is_that_of_the_moment(sea: World) -> None:
    """Of each kind all plants stand at their roots, and wave."""
    now = meshes(sea, "seaweed")
    then = static_meshes(sea, ("seaweed",), 1, StillMoment(9.0, 0.0, np.zeros(3)))
    assert [mesh.name for mesh in now] == [f"seaweed_{kind}" for kind in KINDS]
    for kind, (here, later) in enumerate(zip(now, then, strict=True)):
        roots = sea.state.seaweed.node[sea.state.seaweed.kind == kind, 0, :2]
        near = np.linalg.norm(here.points[:, None, :2] - roots, axis=2).min(axis=0)
        assert near.max() < 5.0
        assert 0.0 < np.abs(here.points - later.points).max() < 20.0
