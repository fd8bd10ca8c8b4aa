"""Manual edits of meshes over a photograph, without a window."""

import numpy as np
import pytest

from subsea.fish.species import load_species
from subsea.studio import mesh_edit
from subsea.studio.deformable_mesh import BODY, DEFAULT, DORSAL, VENTRAL, copy_meshes
from subsea.studio.mesh_edit import MeshNode
from subsea.studio.side_view import centred_matrix, make_fish_meshes, side_view

PLAN = load_species("clownfish").surface
ALL = BODY, DORSAL, VENTRAL
BACK = MeshNode(BODY, 0, 8)


@pytest.fixture
def meshes():
    return make_fish_meshes(PLAN, centred_matrix(400.0, 300.0, PLAN))


def same(a, b, **near):
    return all(np.allclose(one.nodes, b.parts[name].nodes, **near) for name, one in a.parts.items())


def test_the_border_is_every_node_on_an_outline_once(meshes):
    nodes = mesh_edit.border_nodes(meshes, ALL)
    assert len(nodes) == len(set(nodes)) == 2 * 21 + 2 * 7 + 12 + 12
    assert all(node.row == 1 for node in nodes if node.part != BODY)
    assert {node.part for node in mesh_edit.border_nodes(meshes, (DORSAL,))} == {DORSAL}
    assert len(mesh_edit.inner_nodes(meshes, ALL)) == 7 * 19
    assert not mesh_edit.inner_nodes(meshes, (DORSAL,))


def test_a_pulled_node_goes_to_the_hand_and_what_is_far_stays(meshes):
    start, before = mesh_edit.node_places(meshes, [BACK])[0], copy_meshes(meshes)
    to = start + (4.0, -30.0)
    held = mesh_edit.nodes_beyond(meshes, start, 60.0)
    for _ in range(10):
        mesh_edit.pull_node(meshes, BACK, tuple(to), held, DEFAULT, 40)
    moved = np.hypot(*(meshes.body.nodes - before.body.nodes).transpose(2, 0, 1))
    assert moved[0, 8] > 0.85 * 30.0
    assert not moved[held[BODY]].any() and held[BODY].sum() > 100
    # Those beside it follow, the farther the less; the fin that is rooted there comes along.
    assert moved[0, 8] > moved[0, 9] > moved[0, 10] > 0.0
    root = meshes.fins[DORSAL].mesh.nodes[0]
    assert np.allclose(root, meshes.fins[DORSAL].root_weights @ meshes.body.nodes[0])
    assert np.isnan(meshes.body.mouse).all()
    # It stays so once that shape is the one it rests in.
    resting = mesh_edit.with_rest_shape(meshes)
    free = mesh_edit.nodes_beyond(meshes, start, 1e9)
    mesh_edit.pull_node(resting, BACK, tuple(resting.body.nodes[0, 8]), free, DEFAULT, 50)
    assert same(resting, meshes, atol=0.05)


def test_an_anchor_holds_a_node_where_it_was_put_and_goes_with_it(meshes):
    node = MeshNode(VENTRAL, 1, 5)
    held = mesh_edit.with_anchor(meshes, node, (123.0, 45.0))
    assert mesh_edit.anchored_nodes(held) == [node] and mesh_edit.is_anchored(held, node)
    assert not mesh_edit.anchored_nodes(meshes)  # the meshes itself is as it was
    mesh_edit.set_mouse_target(held, node, (130.0, 50.0))
    assert held.fins[VENTRAL].mesh.anchors[1, 5].tolist() == [130.0, 50.0]
    assert not mesh_edit.anchored_nodes(mesh_edit.with_anchor(held, node, None))
    assert not mesh_edit.anchored_nodes(mesh_edit.without_anchors(held))


def test_the_frame_is_about_all_nodes_and_along_the_fish(meshes):
    meshes = mesh_edit.rotate(meshes, np.array([200.0, 150.0]), 0.4)
    frame = mesh_edit.transform_box(meshes)
    for name in meshes.parts:
        for place in meshes.parts[name].nodes.reshape(-1, 2):
            assert mesh_edit.is_inside(frame, tuple(place))
    assert frame.ahead @ (-np.cos(0.4), -np.sin(0.4)) == pytest.approx(1.0, abs=1e-3)
    back, belly = meshes.body.nodes[0].mean(axis=0), meshes.body.nodes[-1].mean(axis=0)
    assert frame.up @ (back - belly) > 0.0
    assert not mesh_edit.is_inside(frame, tuple(frame.knob))


def test_grips_transform_meshes_and_the_opposite_side_stays(meshes):
    frame = mesh_edit.transform_box(meshes)
    grips = np.concatenate([frame.corners, frame.sides, frame.knob[None], frame.middle[None]])
    x = np.column_stack([meshes.body.nodes.reshape(-1, 2), np.ones(meshes.body.nodes[..., 0].size)])
    for grip, begin in enumerate(grips):
        away = (begin - frame.middle) * 0.2 if grip < 8 else np.array([30.0, 10.0])
        there = mesh_edit.drag_grip(meshes, frame, grip, begin, begin + away)
        assert not same(there, meshes, atol=1.0)
        affine = np.linalg.lstsq(x, there.body.nodes.reshape(-1, 2), rcond=None)[0]
        grown = np.sqrt(np.abs(np.linalg.det(affine[:2])))
        expected = 1.1 if grip < 4 else np.sqrt(1.1) if grip < 8 else 1.0
        assert grown == pytest.approx(expected, rel=1e-6)
        if grip < 8:
            other = grips[(grip + 2) % 4 + (4 if grip > 3 else 0)]
            assert other @ affine[:2] + affine[2] == pytest.approx(other)
        assert same(mesh_edit.drag_grip(meshes, frame, grip, begin, begin), meshes)


def test_flipped_twice_it_is_as_it_was_and_once_it_heads_the_other_way(meshes):
    meshes = mesh_edit.rotate(meshes, np.array([10.0, 20.0]), -0.3)
    other = mesh_edit.flip(meshes)
    before, after = mesh_edit.transform_box(meshes), mesh_edit.transform_box(other)
    assert after.ahead == pytest.approx(-before.ahead)
    assert after.up == pytest.approx(before.up)
    assert after.middle == pytest.approx(before.middle)
    assert same(mesh_edit.flip(other), meshes)


def test_springs_as_stiff_as_sliders_allow_never_explode(meshes):
    params = mesh_edit.stable_parameters(DEFAULT._replace(tension=1.0, rigidity=0.6, anchor=2.0))
    rng, before = np.random.default_rng(1), copy_meshes(meshes)
    for one in meshes.parts.values():
        one.nodes[:] += rng.normal(0.0, 4.0, one.nodes.shape)
    free = mesh_edit.nodes_beyond(meshes, meshes.body.nodes[0, 8], 1e9)
    mesh_edit.pull_node(meshes, BACK, (200.0, 0.0), free, params, 600)
    assert np.isfinite(meshes.body.nodes).all()
    assert np.abs(meshes.body.nodes - before.body.nodes).max() < 400.0


def test_the_eye_lies_where_the_species_has_it(meshes):
    rest = side_view(PLAN)
    matrix = centred_matrix(400.0, 300.0, PLAN)
    rim = mesh_edit.eye_outline(meshes, rest, PLAN.eye)
    middle = matrix[:, :2] @ (PLAN.eye.at, PLAN.eye.height) + matrix[:, 2]
    assert (rim.min(axis=0) + rim.max(axis=0)) / 2 == pytest.approx(middle, abs=1.0)
    assert np.ptp(rim, axis=0) == pytest.approx(2 * PLAN.eye.radius * matrix[0, 0], rel=0.1)
