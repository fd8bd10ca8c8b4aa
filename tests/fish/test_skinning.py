"""The skin follows the nodes."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.fish.skinning import skin_weights
from subsea.geometry.rotation import matrix


def _surface(rng, count=200):
    """Points around the body, some beyond nose and tail."""
    return np.stack(
        [rng.uniform(-17, 6, count), rng.uniform(-4, 4, count), rng.uniform(-2, 2, count)], axis=1
    )


def test_at_rest_every_point_is_where_it_was_put(known_repertoire_nodes):
    points = _surface(np.random.default_rng(1))
    W = skin_weights(known_repertoire_nodes, points)
    np.testing.assert_allclose(W @ known_repertoire_nodes, points, atol=1e-10)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_a_rigid_motion_carries_the_skin_along(known_repertoire_nodes, seed):
    rng = np.random.default_rng(seed)
    points = _surface(rng, 40)
    W = skin_weights(known_repertoire_nodes, points)
    q = rng.normal(size=4)
    Q, shift = matrix(q / np.linalg.norm(q)), rng.normal(0, 50, 3)
    moved = W @ (known_repertoire_nodes @ Q.T + shift)
    np.testing.assert_allclose(moved, points @ Q.T + shift, atol=1e-8)


def _sharpest_bend(nodes, bent, count):
    """The largest change of direction between successive pieces of a line on the flank, rad."""
    x = np.linspace(4.9, -14.9, count)
    line = np.stack([x, np.full_like(x, 0.4), np.full_like(x, 1.1)], axis=1)
    pieces = np.diff(skin_weights(nodes, line) @ bent, axis=0)
    pieces /= np.linalg.norm(pieces, axis=1, keepdims=True)
    return np.arccos(np.clip((pieces[1:] * pieces[:-1]).sum(axis=1), -1, 1)).max()


def test_no_crease_where_the_body_bends(known_repertoire_nodes, known_motion):
    """Twice as fine a line bends half as much per piece: there is no corner at the rings."""
    bent = known_motion(4.0, 0.2, 12, 0.0, 0.0)
    coarse = _sharpest_bend(known_repertoire_nodes, bent, 400)
    fine = _sharpest_bend(known_repertoire_nodes, bent, 800)
    assert fine < 0.55 * coarse
