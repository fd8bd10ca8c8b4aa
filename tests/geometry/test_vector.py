"""Vectors as tuples agree with numpy."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry import vector as v

vectors = st.tuples(*[st.floats(-1e3, 1e3)] * 3)


@given(vectors, vectors, st.floats(-10, 10))
def test_every_function_is_numpys(a, b, k):
    p, q = np.array(a), np.array(b)
    np.testing.assert_allclose(v.plus(a, b), p + q)
    np.testing.assert_allclose(v.minus(a, b), p - q)
    np.testing.assert_allclose(v.times(k, a), k * p)
    np.testing.assert_allclose(v.dot(a, b), p @ q, atol=1e-9)
    np.testing.assert_allclose(v.cross(a, b), np.cross(p, q), atol=1e-9)
    np.testing.assert_allclose(v.norm(a), np.linalg.norm(p))
    assert v.vector(p.astype(np.float32)) == tuple(float(x) for x in p.astype(np.float32))


@given(vectors.filter(lambda a: np.linalg.norm(a) > 1e-6))
def test_a_direction_has_length_one(a):
    np.testing.assert_allclose(v.unit(a), np.array(a) / np.linalg.norm(a))
