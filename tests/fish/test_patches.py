"""Tu's patches: bilinear faces, and offsets in axes that move with them."""

import numpy as np

from subsea.fish.skinning import FACES, PATCH_FACE, PATCH_NODES, couple, face_axes, place


def test_a_face_has_twenty_five_patch_nodes_and_its_corners_are_four_of_them():
    assert len(FACES) == 24
    assert np.bincount(PATCH_FACE).tolist() == [25] * 24
    for face, corners in enumerate(FACES):
        own = PATCH_NODES[face == PATCH_FACE]
        for corner in set(corners):
            assert (own[:, corner] == 1).any()
        centre = np.zeros(23)
        np.add.at(centre, corners, 0.25)
        np.testing.assert_allclose(own[12], centre)


def test_axes_are_right_handed_and_point_outwards_and_tailward(known_repertoire_nodes):
    nodes = known_repertoire_nodes
    axes = face_axes(nodes)
    np.testing.assert_allclose(np.linalg.det(axes), 1)
    np.testing.assert_allclose(axes @ np.swapaxes(axes, 1, 2), np.tile(np.eye(3), (24, 1, 1)),
                               atol=1e-12)  # fmt: skip
    middle = nodes[FACES].mean(axis=1)
    outward = middle - [[x, 0.0, 0.0] for x in middle[:, 0]]
    inside = slice(0, 20)  # of the tail's faces the flanks pass through the axis
    assert ((axes[:, :, 0] * outward).sum(axis=1)[inside] > 0).all()
    assert (axes[:, 0, 1] < 0).all()


def test_a_patch_node_of_a_face_needs_no_offset_and_follows_the_bilinear_surface(
    known_repertoire_nodes, known_motion
):
    chosen = np.flatnonzero((PATCH_FACE >= 4) & (PATCH_FACE < 20))
    points = PATCH_NODES[chosen] @ known_repertoire_nodes
    coupling = couple("patches", known_repertoire_nodes, points)
    np.testing.assert_allclose(coupling.offset, 0, atol=1e-9)
    bent = known_motion(3.0, 0.2, 12, 0.0, 0.0)
    np.testing.assert_allclose(place(coupling, bent), PATCH_NODES[chosen] @ bent, atol=1e-9)


def test_an_offset_keeps_its_length_and_turns_with_its_face(known_repertoire_nodes, known_motion):
    rng = np.random.default_rng(4)
    points = rng.uniform([-17, -4, -2], [6, 4, 2], (200, 3))
    coupling = couple("patches", known_repertoire_nodes, points)
    bent = known_motion(6.0, 0.2, 12, 0.0, 0.0)
    offset = place(coupling, bent) - coupling.weights @ bent
    axes = face_axes(bent)[coupling.face]
    np.testing.assert_allclose(np.einsum("pji,pj->pi", axes, offset), coupling.offset, atol=1e-9)
    assert np.abs(coupling.offset).max() > 1
