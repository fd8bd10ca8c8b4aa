"""Error messages suggest the packages that the set-up installs, and say what does not fit."""

import re
import tomllib
from pathlib import Path

import pytest

from subsea.base import system

ROOT = Path(__file__).parents[2]
SETUP = (ROOT / "tools" / "setup.sh").read_text(encoding="utf-8")


def test_the_libraries_are_those_of_the_setup():
    lists = dict(re.findall(r'^([A-Z]+)="(.*)"$', SETUP, re.MULTILINE))
    assert (lists["HEADLESS"], lists["WINDOW"]) == (system.HEADLESS, system.WINDOW)


def test_the_workshop_setup_has_every_extra_except_cluster_and_train():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    [line] = re.findall(r'^bench\) groups="(.*?)"', SETUP, re.MULTILINE)
    extras = set(project["project"]["optional-dependencies"])
    assert set(re.findall(r"--extra (\w+)", line)) == extras - {"cluster", "train"}
    assert "--no-dev" in line


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (ModuleNotFoundError("No module named 'glfw'"), f"run `{system.BASE_COMMAND}`"),
        (
            ImportError("libX11.so.6: cannot open shared object file: No such file or directory"),
            f"on Debian or Ubuntu: {system.INSTALL_WINDOW}",
        ),
        (
            ImportError("/lib/panel.so: undefined symbol: glfwGetX11Window"),
            "a shared library does not fit: /lib/panel.so: undefined symbol: glfwGetX11Window; "
            "install the packages again",
        ),
    ],
)
def test_what_cannot_be_imported_is_told_apart(fault, words, monkeypatch):
    for name in system.LIBRARY_SETTINGS:
        monkeypatch.delenv(name, raising=False)
    assert system.import_fault(fault).endswith(words)


def test_a_setting_that_selects_libraries_is_named(monkeypatch):
    monkeypatch.setenv("LD_PRELOAD", "/opt/old.so")
    assert "try without LD_PRELOAD" in system.import_fault(ImportError("undefined symbol: x"))
