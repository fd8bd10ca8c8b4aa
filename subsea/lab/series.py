"""Stretches and headings in the time series of a record."""

from collections.abc import Iterator

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.geometry.rotation import matrix

SAMPLE_S = 0.2  # interval at which the shape of schools is sampled


def headings(orientation: Array) -> Array:
    """Unit vectors (..., 3) along the body, of quaternions (..., 4)."""
    return np.asarray(matrix(np.asarray(orientation, np.float64))[..., 0])


def runs(flags: Bools) -> Iterator[tuple[int, int]]:
    """Beginnings and ends of the stretches in which flags (k,) hold."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2):
        yield int(start), int(end)
