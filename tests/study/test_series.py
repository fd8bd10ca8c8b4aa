"""Stretches of a time series."""

import numpy as np
import pytest

from subsea.study.series import runs


@pytest.mark.parametrize(
    ("flags", "expected"),
    [([], []), ([1, 1], [(0, 2)]), ([0, 1, 0, 1, 1], [(1, 2), (3, 5)]), ([0, 0], [])],
)
def test_runs(flags, expected):
    assert list(runs(np.array(flags, bool))) == expected
