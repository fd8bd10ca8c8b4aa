"""Keyed random numbers."""

import importlib
import pkgutil

import numpy as np

import subsea
from subsea.geometry.noise import uniform


def test_same_keys_same_number_other_keys_other_numbers():
    assert uniform(1, 2, 3, 4) == uniform(1, 2, 3, 4)
    keys = [(1, 2, 3, 4), (2, 2, 3, 4), (1, 3, 3, 4), (1, 2, 4, 4), (1, 2, 3, 5), (1, 3, 2, 4)]
    assert len({uniform(*k) for k in keys}) == len(keys)


def test_numbers_are_even_and_independent_of_their_neighbours():
    values = np.array([[uniform(7, fish, tick, 0) for tick in range(100)] for fish in range(100)])
    counts, _ = np.histogram(values, bins=10, range=(0, 1))
    assert ((counts - 1000) ** 2 / 1000).sum() < 27.9  # chi-square, 9 degrees, p = 0.001
    assert abs(np.corrcoef(values[:, :-1].ravel(), values[:, 1:].ravel())[0, 1]) < 0.035
    assert abs(np.corrcoef(values[:-1].ravel(), values[1:].ravel())[0, 1]) < 0.035


def test_no_two_purposes_share_their_random_numbers():
    found = {}
    for module in pkgutil.walk_packages(subsea.__path__, "subsea."):
        folder = module.name.split(".")[1]
        if folder not in ("behavior", "fish", "habitat", "motor", "perception", "state", "world"):
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            if name.endswith("_PURPOSE"):
                found.setdefault(int(value), set()).add(name)
    assert len(found) > 15
    assert [names for names in found.values() if len(names) > 1] == []
