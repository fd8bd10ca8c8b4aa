"""Properties of all three couplings of surface points to nodes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.fish.skinning import couple, place, skin_weights
from subsea.geometry.rotation import matrix
from tests.support.daily import examples

WAYS = ["sections", "patches", "tetrahedra"]


def _points(rng, count=150):
    """Around the body, some beyond nose and tail."""
    return rng.uniform([-17, -4, -2], [6, 4, 2], (count, 3))


@pytest.mark.parametrize("way", WAYS)
def test_points_lie_in_place_at_rest_in_one_frame_or_many(known_repertoire, way):
    rest, nodes = known_repertoire.rest_nodes, known_repertoire.segments["swim_fast"].nodes
    points = _points(np.random.default_rng(1))
    coupling = couple(way, rest, points)
    np.testing.assert_allclose(place(coupling, rest), points, atol=1e-9)
    np.testing.assert_allclose(coupling.weights.sum(axis=1), 1, atol=1e-12)
    every = place(coupling, nodes)
    assert every.shape == (len(nodes), len(points), 3)
    np.testing.assert_allclose(every[3], place(coupling, nodes[3]), atol=1e-12)


@pytest.mark.parametrize("way", WAYS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=examples(8))
def test_points_follow_rigid_motion_of_a_bent_body(known_repertoire_nodes, known_motion, way, seed):
    rng = np.random.default_rng(seed)
    coupling = couple(way, known_repertoire_nodes, _points(rng, 40))
    bent = known_motion(rng.uniform(0, 12), 0.2, 12, 0.0, 0.0)
    q = rng.normal(size=4)
    turn, shift = matrix(q / np.linalg.norm(q)), rng.normal(0, 50, 3)
    moved = place(coupling, bent @ turn.T + shift)
    np.testing.assert_allclose(moved, place(coupling, bent) @ turn.T + shift, atol=1e-8)


@pytest.mark.parametrize("way", ["sections", "patches"])  # five tetrahedra are not symmetric
def test_a_mirrored_fish_has_a_mirrored_surface(known_repertoire_nodes, known_motion, way):
    mirror = np.array([0, *(1 + 4 * r + k for r in range(5) for k in (1, 0, 3, 2)), 21, 22])
    points = _points(np.random.default_rng(3))
    bent = known_motion(5.0, 0.2, 12, 0.0, 0.0)
    right = place(couple(way, known_repertoire_nodes, points), bent)
    flip = np.array([1.0, 1.0, -1.0])
    left = place(couple(way, known_repertoire_nodes, points * flip), bent[mirror] * flip)
    np.testing.assert_allclose(left, right * flip, atol=1e-9)


def _largest_bend(nodes, bent, count):
    """The largest change of direction between successive pieces of a line on the flank, rad."""
    x = np.linspace(4.9, -14.9, count)
    line = np.stack([x, np.full_like(x, 0.4), np.full_like(x, 1.1)], axis=1)
    pieces = np.diff(skin_weights(nodes, line) @ bent, axis=0)
    pieces /= np.linalg.norm(pieces, axis=1, keepdims=True)
    return np.arccos(np.clip((pieces[1:] * pieces[:-1]).sum(axis=1), -1, 1)).max()


def test_sections_bend_without_a_crease(known_repertoire_nodes, known_motion):
    """Twice as fine a line bends half as much per piece: there is no corner at the rings."""
    bent = known_motion(4.0, 0.2, 12, 0.0, 0.0)
    coarse = _largest_bend(known_repertoire_nodes, bent, 400)
    fine = _largest_bend(known_repertoire_nodes, bent, 800)
    assert fine < 0.55 * coarse
