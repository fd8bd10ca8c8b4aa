"""Photographs that are made, so that the truth about them is known."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from subsea.studio.deformable_mesh import attach_fins


@pytest.fixture(scope="session")
def accuracy():
    """The script that makes them, as a module."""
    path = Path(__file__).parents[2] / "docs/skin_accuracy.py"
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


@pytest.fixture
def climb():
    """Moves the body's border under a fin by a share of the way to the fin's edge."""

    def climb(meshes, name, share):
        fin = meshes.fins[name]
        way = fin.root_weights.T @ (share * (fin.mesh.nodes[1] - fin.mesh.nodes[0]))
        meshes.body.nodes[fin.row] += way / np.maximum(fin.root_weights.sum(0), 1.0)[:, None]
        attach_fins(meshes)

    return climb
