"""The notebooks of the site run from the first cell to the last."""

import nbformat
import pytest
from nbclient import NotebookClient

from tests.docs.test_site import ROOT

NOTEBOOKS = sorted(ROOT.glob("docs/notebooks/*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs(path, tmp_path):
    notebook = nbformat.read(path, as_version=4)
    assert any(cell.get("outputs") for cell in notebook.cells)  # which the site shows
    client = NotebookClient(notebook, timeout=240, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()  # raises where a cell does


def test_there_are_notebooks():
    assert len(NOTEBOOKS) == 3
