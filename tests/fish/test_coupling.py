"""Points hang on the nodes in three ways, which agree about what any skin must do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.fish.coupling import couple, place
from subsea.geometry.rotation import matrix

WAYS = ["sections", "patches", "tetrahedra"]


def _points(rng, count=150):
    """Around the body, some beyond nose and tail."""
    return rng.uniform([-17, -4, -2], [6, 4, 2], (count, 3))


@pytest.mark.parametrize("way", WAYS)
def test_at_rest_every_point_is_where_it_was_put(known_repertoire_nodes, way):
    points = _points(np.random.default_rng(1))
    coupling = couple(way, known_repertoire_nodes, points)
    np.testing.assert_allclose(place(coupling, known_repertoire_nodes), points, atol=1e-9)
    np.testing.assert_allclose(coupling.weights.sum(axis=1), 1, atol=1e-12)


@pytest.mark.parametrize("way", WAYS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_a_rigid_motion_carries_the_points_along(known_repertoire_nodes, known_motion, way, seed):
    """Of a bent body too."""
    rng = np.random.default_rng(seed)
    coupling = couple(way, known_repertoire_nodes, _points(rng, 40))
    bent = known_motion(rng.uniform(0, 12), 0.2, 12, 0.0, 0.0)
    q = rng.normal(size=4)
    turn, shift = matrix(q / np.linalg.norm(q)), rng.normal(0, 50, 3)
    moved = place(coupling, bent @ turn.T + shift)
    np.testing.assert_allclose(moved, place(coupling, bent) @ turn.T + shift, atol=1e-8)


@pytest.mark.parametrize("way", WAYS)
def test_many_frames_at_once_are_those_one_by_one(known_repertoire, way):
    nodes = known_repertoire.segments["swim_fast"].nodes
    points = _points(np.random.default_rng(2))
    coupling = couple(way, known_repertoire.rest_nodes, points)
    every = place(coupling, nodes)
    assert every.shape == (len(nodes), len(points), 3)
    np.testing.assert_allclose(every[3], place(coupling, nodes[3]), atol=1e-12)


@pytest.mark.parametrize("way", ["sections", "patches"])  # five tetrahedra are not symmetric
def test_the_mirror_image_of_a_fish_has_the_mirror_image_of_its_surface(
    known_repertoire_nodes, known_motion, way
):
    mirror = np.array([0, *(1 + 4 * r + k for r in range(5) for k in (1, 0, 3, 2)), 21, 22])
    points = _points(np.random.default_rng(3))
    bent = known_motion(5.0, 0.2, 12, 0.0, 0.0)
    right = place(couple(way, known_repertoire_nodes, points), bent)
    flip = np.array([1.0, 1.0, -1.0])
    left = place(couple(way, known_repertoire_nodes, points * flip), bent[mirror] * flip)
    np.testing.assert_allclose(left, right * flip, atol=1e-9)
