"""Fishes seen from the side, and the meshes that stand for them in a picture."""

import cv2
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.fish.mesh import DETAILS, FIN, fish_mesh, surface_points
from subsea.fish.species import load_species, species_names
from subsea.fish.surface import rest_control_points
from subsea.studio.deformable_mesh import BODY, step
from subsea.studio.side_view import (
    centred_matrix,
    make_fish_meshes,
    mesh_outlines,
    side_view,
    subdivide,
    to_picture,
)

FISHES = [name for name in species_names() if load_species(name).surface.wing is None]


def depth(rings, places):
    """Return the depth of places inside the union of rings, pixels; negative outside."""
    return np.array(
        [
            max(cv2.pointPolygonTest(r.astype(np.float32), tuple(p), True) for r in rings)
            for p in places.astype(float)
        ]
    )


@pytest.mark.parametrize("name", FISHES)
def test_the_meshes_cover_what_is_drawn_and_no_more(name):
    plan = load_species(name).surface
    matrix = centred_matrix(1000.0, 800.0, plan)
    length = matrix[0, 0]
    meshes = make_fish_meshes(plan, matrix)
    mesh = fish_mesh(DETAILS[0])
    there = mesh.vertices[:, 12] <= FIN
    control = rest_control_points(plan, 1.0, 0.0)
    points = surface_points(control, mesh.vertices[there], mesh.base[there])
    drawn = to_picture(matrix, points[:, :2] * (-1.0, 1.0))
    if not (plan.dorsal and plan.ventral):
        drawn = drawn[mesh.vertices[there, 12] == 0]
    assert depth(mesh_outlines(meshes), drawn).min() > -0.006 * length
    for ring in mesh_outlines(meshes):
        gap = np.linalg.norm(ring[:, None] - drawn, axis=2).min(axis=1)
        # From one vertex to the next is 5% of the length where they are far apart.
        assert gap.max() < 0.05 * length
        assert gap.mean() < 0.02 * length


def test_meshes_rest_as_they_are_laid():
    meshes = make_fish_meshes(
        load_species("clownfish").surface,
        centred_matrix(600, 400, load_species("clownfish").surface),
    )
    before = [one.nodes.copy() for one in meshes.parts.values()]
    assert len(before) == 3
    assert step(meshes, None, times=20) < 1e-9
    for old, one in zip(before, meshes.parts.values(), strict=True):
        np.testing.assert_allclose(old, one.nodes)


def test_a_fish_heads_left_and_stands_upright():
    plan = load_species("blacktip_reef_shark").surface
    meshes = make_fish_meshes(plan, centred_matrix(800, 600, plan))
    assert meshes.body.nodes[4, 0, 0] < 100 < 700 < meshes.body.nodes[0, 20, 0]
    assert meshes.body.nodes[0, 10, 1] < meshes.body.nodes[8, 10, 1]
    assert all(
        ring.min() > 0 and (ring.max(axis=0) < (800, 600)).all() for ring in mesh_outlines(meshes)
    )


def test_nothing_is_felt_under_fins_but_between_two_of_them():
    plan = load_species("blacktip_reef_shark").surface
    meshes, rest = make_fish_meshes(plan, centred_matrix(800, 600, plan)), side_view(plan)
    at = rest.body[0, :, 0]
    assert meshes.body.edge_weight[0, (at > 0.35) & (at < 0.45)].max() == 0.0  # the first fin
    assert meshes.body.edge_weight[0, (at > 0.5) & (at < 0.58)].min() == 1.0
    assert meshes.body.edge_weight[1:-1, 1:-1].max() == 0.0
    assert meshes.body.edge_weight[:, -1].min() == 1.0


def test_finer_meshes_meet_their_nodes():
    rng = np.random.default_rng(1)
    nodes = rng.normal(size=(9, 21, 2))
    np.testing.assert_allclose(subdivide(nodes, 4)[::4, ::4], nodes, atol=1e-9)
    assert subdivide(rng.normal(size=(2, 12, 2)), 4).shape == (2, 45, 2)


def test_wings_are_not_seen_from_the_side():
    with pytest.raises(UserError, match="from above"):
        side_view(load_species("spotted_eagle_ray").surface)
    assert BODY in make_fish_meshes(load_species("fusilier").surface, np.eye(3)[:2]).parts
