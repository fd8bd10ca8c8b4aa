"""What other packages add: installed with pip, used by the program, refused in a line."""

import os
import subprocess
import sys
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path

import pytest

from subsea.base import registry
from subsea.base.errors import UserError
from subsea.lab.records import simulate
from tests.support.scenes import BARE

OUTSIDE = Path(__file__).parents[1] / "support" / "outside"


@pytest.fixture(scope="module")
def outside(tmp_path_factory):
    """The environment of a process in which the package of somebody else is installed."""
    folder = tmp_path_factory.mktemp("site")
    subprocess.run(
        [
            sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check",
            "--no-deps", "--no-build-isolation", "--no-index", "--target", str(folder),
            str(OUTSIDE),
        ],
        check=True,
    )  # fmt: skip
    return os.environ | {"PYTHONPATH": str(folder)}


def subsea(environment, *words):
    """Run a command of subsea; returns the process, which has ended."""
    return subprocess.run(
        [sys.executable, "-m", "subsea", *words],
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_a_command_of_another_package_is_listed_and_runs(outside):
    assert subsea(outside, "tide").stdout == "the tide is high\n"
    text = subsea(outside, "--help").stdout
    assert "from other packages:\n  tide        tell the tide" in text
    assert text.index("this machine:") < text.index("from other packages:")


@pytest.mark.nightly
def test_a_part_of_another_package_takes_part_in_a_dive(outside, display, quiet):
    words = ["--scenario", quiet, "--seconds", "0.5", "--size", "160x120", "--quality", "low"]
    done = subsea(outside | {"DISPLAY": display}, "dive", *words, "--greet", "Ann")
    lines = done.stderr.splitlines()
    assert done.returncode == 0, done.stderr
    assert (
        f"subsea: welcome to {Path(quiet).stem}, Ann" in lines and "subsea: farewell, Ann" in lines
    )


@pytest.mark.nightly
def test_a_format_of_another_package_is_a_theatre(outside, tmp_path):
    path = tmp_path / "mast.sail"
    path.write_text("sail 300x200")
    done = subsea(outside, "theatre", str(path))
    assert done.returncode == 0 and "window sail: 300x200 pixels" in done.stdout


DOZING = """
import numpy as np
import subsea
world = subsea.load("peaceful", fish=20)
world.step(60)
print([world.names["minds.intention"][code] for code in np.unique(world.minds.intention)])
"""


def test_fishes_follow_a_behavior_of_another_package(outside):
    done = subprocess.run(
        [sys.executable, "-c", DOZING], env=outside, capture_output=True, text=True, check=False
    )
    assert "doze" in done.stdout, done.stderr


@pytest.mark.nightly
def test_a_measure_of_another_package_is_a_row(outside, tmp_path):
    path = simulate(str(BARE), tmp_path / "run.h5", seconds=0.1, fish=4)
    done = subsea(outside, "study", str(path), "--measure", "depth")
    assert done.returncode == 0, done.stderr
    assert [line.split()[:2] for line in done.stdout.splitlines()[-2:]] == [
        ["depth_cm", "least"], ["depth_cm", "most"],
    ]  # fmt: skip
    done = subsea(outside, "study", str(path), "--measure", "depht")
    assert done.stderr == "subsea: unknown measure 'depht'; did you mean 'depth'?\n"


def points(*given):
    """Stand-ins for the entry points that packages have."""
    made = EntryPoints(EntryPoint(name, value, registry.COMMANDS) for name, value in given)
    return lambda: made


def test_no_package_replaces_what_is_ours(monkeypatch):
    both = ("film", "others.film"), ("film", "subsea.cli.film"), ("tide", "others.tide")
    monkeypatch.setattr(registry, "_installed", points(*both))
    found = registry.registered(registry.COMMANDS)
    assert [point.value for point in found.values()] == ["subsea.cli.film", "others.tide"]


def test_a_package_that_cannot_be_loaded_is_a_line_and_all_else_works(monkeypatch, capsys):
    given = ("gone", "no_such_package.gone"), ("say", "subsea.base.progress:say")
    monkeypatch.setattr(registry, "_installed", points(*given))
    assert [name for name, _ in registry.load_all(registry.COMMANDS)] == ["say"]
    (line,) = capsys.readouterr().err.splitlines()
    assert "cannot load no_such_package.gone of subsea.commands" in line
    with pytest.raises(UserError, match="update or uninstall the package"):
        registry.load_named(registry.COMMANDS, "gone", "command")
    with pytest.raises(UserError, match="unknown command 'sai'; did you mean 'say'"):
        registry.load_named(registry.COMMANDS, "sai", "command")
