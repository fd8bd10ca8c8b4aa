"""Every example in a docstring of the library runs and prints what it says."""

import doctest
from importlib import import_module

import pytest

import subsea

MODULES = sorted({"subsea", *subsea._PLACES.values()})


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = import_module(name)
    done = doctest.testmod(module, extraglobs={"subsea": subsea}, optionflags=doctest.ELLIPSIS)
    assert done.failed == 0


def test_there_are_examples():
    finder = doctest.DocTestFinder()
    found = {
        test.name for name in MODULES for test in finder.find(import_module(name)) if test.examples
    }
    assert {"subsea", "subsea.library.load", "subsea.lab.records.measure"} <= found
