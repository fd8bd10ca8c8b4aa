"""Photographs that are made, so that the truth about them is known."""

import importlib.util
import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def accuracy():
    """The script that makes them, as a module."""
    path = Path(__file__).parents[3] / "docs/skin_accuracy.py"
    spec = importlib.util.spec_from_file_location("skin_accuracy", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["skin_accuracy"] = module
    spec.loader.exec_module(module)
    module.FINER = 2  # half the work
    return module


@pytest.fixture(scope="session")
def clownfish_photo(accuracy):
    """A clownfish in plain water, its photograph and its outline."""
    return accuracy.made(accuracy.Case("clownfish", length=420.0, size=(600, 420), seed=2))
