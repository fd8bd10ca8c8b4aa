"""The command that installs a missing package fits the installation."""

import sys

import pytest

from subsea.base import system as extras
from subsea.base.errors import UserError


@pytest.mark.parametrize(
    ("extra", "module", "checkout", "installed"),
    [
        ("plot", "matplotlib", "make bench", 'pip install "subsea[plot]"'),
        (
            "cluster", "distributed", ".venv/bin/uv sync --inexact --extra cluster",
            'pip install "subsea[cluster]"',
        ),
    ],
)  # fmt: skip
def test_the_command_fits_a_checkout_or_an_installed_package(
    monkeypatch, tmp_path, extra, module, checkout, installed
):
    monkeypatch.setitem(sys.modules, module, None)
    name = extras.EXTRAS[extra][module]
    with pytest.raises(UserError) as fault:
        extras.require(extra, "this")
    assert str(fault.value).endswith(f"{name}: run `{checkout}`")
    monkeypatch.setattr(extras, "CHECKOUT", tmp_path / "pyproject.toml")
    with pytest.raises(UserError) as fault:
        extras.require(extra, "it")
    assert str(fault.value) == f"it needs {name}: run `{installed}`"


def test_an_installed_extra_is_not_missing(monkeypatch):
    monkeypatch.setitem(extras.EXTRAS, "plot", {"json": "json"})
    extras.require("plot", "plots")


def test_the_extras_are_those_of_the_package():
    import tomllib

    project = tomllib.loads(extras.CHECKOUT.read_text())["project"]
    assert extras.EXTRAS.keys() == project["optional-dependencies"].keys()
