"""Stretches of a time series."""

import numpy as np

from subsea.lab.measures import runs


def test_runs_are_the_stretches_of_true_flags():
    assert list(runs(np.array([], bool))) == []
    assert list(runs(np.array([1, 1], bool))) == [(0, 2)]
    assert list(runs(np.array([0, 1, 0, 1, 1], bool))) == [(1, 2), (3, 5)]
    assert list(runs(np.array([0, 0], bool))) == []
