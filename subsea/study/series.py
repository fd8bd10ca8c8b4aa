"""Stretches and headings in the time series of a record."""

from collections.abc import Iterator

import numpy as np

from subsea.core.arrays import Array, Bools

SAMPLE_S = 0.2  # interval at which the shape of schools is sampled


def headings(orientation: Array) -> Array:
    """Unit vectors (..., 3) along the body, of quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(orientation, np.float64), -1, 0)
    parts = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    return np.stack(parts, axis=-1)


def runs(flags: Bools) -> Iterator[tuple[int, int]]:
    """Beginnings and ends of the stretches in which flags (k,) hold."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2):
        yield int(start), int(end)
