"""KS's coupling: the scaffold in tetrahedra, a mesh in barycentric coordinates."""

from collections import Counter

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from subsea.biomechanics.body import TRIANGLE_WEIGHTS, TRIANGLES
from subsea.geometry.tetrahedra import TETRAHEDRA, tetrahedral_weights


def test_tetrahedra_fill_the_hull_and_overlap_nowhere(known_repertoire_nodes):
    corners = known_repertoire_nodes[TETRAHEDRA]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    a, b, c = np.moveaxis(known_repertoire_nodes[TRIANGLES], 1, 0)
    hull = TRIANGLE_WEIGHTS @ np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    assert (volumes > 0.1).all()
    np.testing.assert_allclose(volumes.sum(), hull)


def test_neighbours_share_whole_faces():
    """No face has more than two owners, and those inside have two."""
    owners = Counter(
        tuple(sorted(corner for corner in tetrahedron if corner != left_out))
        for tetrahedron in TETRAHEDRA
        for left_out in tetrahedron
    )
    # Outside: 4 triangles at the nose, 32 of the sections' quadrilaterals, 6 at the tail.
    assert Counter(owners.values()) == {1: 42, 2: (4 * len(TETRAHEDRA) - 42) // 2}


@given(st.integers(0, 2**32 - 1))
def test_inside_a_tetrahedron_the_coordinates_are_barycentric(known_repertoire_nodes, seed):
    rng = np.random.default_rng(seed)
    which = rng.integers(len(TETRAHEDRA))
    shares = rng.dirichlet(np.ones(4))
    point = shares @ known_repertoire_nodes[TETRAHEDRA[which]]
    weights = tetrahedral_weights(known_repertoire_nodes, point[None])[0]
    expected = np.zeros(23)
    expected[TETRAHEDRA[which]] = shares
    np.testing.assert_allclose(weights, expected, atol=1e-9)


def test_an_affine_motion_of_the_scaffold_is_that_of_the_mesh(known_repertoire_nodes):
    """Shear and stretch included, and also for points outside."""
    rng = np.random.default_rng(5)
    points = rng.uniform([-17, -4, -2], [6, 4, 2], (100, 3))
    weights = tetrahedral_weights(known_repertoire_nodes, points)
    bend, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    moved = weights @ (known_repertoire_nodes @ bend.T + shift)
    np.testing.assert_allclose(moved, points @ bend.T + shift, atol=1e-8)
    assert (np.count_nonzero(weights, axis=1) <= 4).all()
