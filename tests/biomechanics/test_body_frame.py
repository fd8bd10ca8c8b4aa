"""The body frame of SMC eqs. 1-5."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from subsea.biomechanics.body import body_frame, to_body, to_world
from subsea.geometry.rotation import matrix

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_the_frame_stays_orthonormal_in_deformed_bodies(known_repertoire_nodes, seed):
    rng = np.random.default_rng(seed)
    nodes = known_repertoire_nodes + rng.normal(0, 0.3, (23, 3))
    _, R = body_frame(nodes)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) > 0


@given(seeds)
def test_the_frame_moves_with_the_body(known_repertoire_nodes, seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    Q, shift = matrix(q / np.linalg.norm(q)), rng.normal(0, 100, 3)
    origin, R = body_frame(known_repertoire_nodes @ Q.T + shift)
    np.testing.assert_allclose(origin, shift, atol=1e-10)
    np.testing.assert_allclose(R, Q, atol=1e-10)
    body = to_body(known_repertoire_nodes @ Q.T + shift, origin, R)
    np.testing.assert_allclose(body, known_repertoire_nodes, atol=1e-9)
    np.testing.assert_allclose(
        to_world(body, origin, R), known_repertoire_nodes @ Q.T + shift, atol=1e-9
    )
