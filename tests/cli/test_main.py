"""The command line as a shell sees it: exit codes, one line for every fault, examples."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from subsea.cli.main import main
from subsea.core.resources import resource_path

COMMANDS = (
    "dive", "film", "theatre", "simulate", "study", "benchmark", "soak", "skin", "build", "doctor",
    "keys", "settings",
)  # fmt: skip
DOOR = Path(__file__).parents[2] / "run_submarine.py"


def run(capsys, *arguments):
    """Exit code, standard output and the lines of standard error."""
    code = main(list(arguments))
    captured = capsys.readouterr()
    return code, captured.out, captured.err.splitlines()


def test_no_command_shows_the_help(capsys):
    code, out, err = run(capsys)
    assert code == 0
    assert all(command in out for command in COMMANDS)
    assert not err


def test_every_command_has_help_with_examples(capsys):
    for command in COMMANDS:
        with pytest.raises(SystemExit) as exit:
            main([command, "--help"])
        assert exit.value.code == 0
        assert f"examples:\n  subsea {command}" in capsys.readouterr().out


def test_help_loads_nothing_heavy():
    program = "import sys, subsea.cli.main as m; m.parsers(); print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    heavy = {"numpy", "numba", "h5py", "moderngl", "glfw", "imgui_bundle", "av", "PIL", "msgspec"}
    assert not heavy & set(done.stdout.split())


FAULTS = [
    (["flim"], "'film'"),
    (["--sed", "3"], "--sed"),
    (["dive", "--sed", "3"], "'--seed'"),
    (["dive", "--seed"], "expected one argument"),
    (["dive", "--seed", "-1"], "from 0"),
    (["dive", "--seed", "x"], "whole number"),
    (["dive", "--size", "1280"], "1280x720"),
    (["dive", "--size", "1x1"], "64 to 8192"),
    (["dive", "--seconds", "nan"], "from 0.1"),
    (["dive", "--display", "top-bottm"], "'top-bottom'"),
    (["dive", "--scenario", "peacefull"], "'peaceful'"),
    (["dive", "--scenario", "nowhere/reef.toml"], "nowhere/reef.toml"),
    (["dive", "deeper"], "'deeper'"),
    (["dive", "--gaze", "30,-10"], "--gaze needs --eyes FISH or --follow FISH"),
    (["dive", "--reins"], "--reins needs --eyes FISH or --follow FISH"),
    (["dive", "--eyes", "1", "--follow", "2"], "expected one"),
    (["dive", "--pace", "3"], "0, 0.25, 0.5, 1, 2 or 4"),
    (["film"], "OUT"),
    (["film", "dive.avi"], ".mp4"),
    (["film", "a.mp4", "--fps", "0"], "from 1"),
    (["film", "a.mp4", "b.mp4"], "'b.mp4'"),
    (["film", "a.png", "--scenario", "peacefull"], "'peaceful'"),
    (["simulate", "--out", "a.h5"], "--ticks"),
    (["simulate", "--ticks", "0", "--out", "a.h5"], "from 1"),
    (["simulate", "--ticks", "1.5", "--out", "a.h5"], "whole number"),
    (["simulate", "--ticks", "5", "--out", "/proc/none/a.h5"], "/proc/none"),
    (["benchmark", "--without", "culing"], "'culling'"),
    (["benchmark", "--frames", "many"], "whole number"),
    (["benchmark", "--fish", "0"], "from 1"),
    (["simulate", "--ticks", "5", "--out", "a.csv"], ".h5 or .hdf5"),
    (["study"], "RECORD.h5"),
    (["study", "nowhere.h5"], "no such file"),
    (["benchmark", "--json", "/tmp"], "expected the name of a file"),
    (["benchmark", "--scenario", "peacefull"], "'peaceful'"),
    (["benchmark", "--paper", "--json", "a.json"], "'--json'"),
    (["benchmark", "--fish=9", "--paper"], "'--fish=9'"),
    (["film", "/proc/a.png"], "/proc"),
    (["film", "a" * 300 + ".mp4"], "too long"),
    (["simulate", "--ticks", "5", "--out", "a" * 300 + ".h5"], "too long"),
    (["benchmark", "--json", "a" * 300 + "/report.json"], "too long"),
    (["benchmark", "--json", "/proc/none/a.json"], "/proc/none"),
    (["doctor", "--quick"], "--quick"),
    (["keys", "here"], "NAME"),
    (["dive", "--node", "left"], "--node needs --theatre too"),
    (["keys", "here", "../left"], "expected a name"),
    (["dive", "--settings", "nowhere/mine.toml"], "nowhere/mine.toml: cannot read"),
    (["settings", "--writ"], "'--write'"),
]


def test_every_fault_is_one_line_with_a_hint(capsys):
    for arguments, hint in FAULTS:
        code, out, err = run(capsys, *arguments)
        assert code == 2, arguments
        assert not out, arguments
        assert len(err) == 1, err
        assert hint in err[0], arguments


@pytest.mark.parametrize(
    "text",
    ["", "title = 3", "seed = [", 'title = "x"\nunknown = 1'],
    ids=["empty", "wrong type", "not TOML", "unknown key"],
)
def test_a_faulty_scenario_file_is_named(capsys, tmp_path, text):
    path = tmp_path / "reef.toml"
    path.write_text(text)
    code, _, err = run(capsys, "simulate", "--ticks", "1", "--out", "x.h5", "--scenario", str(path))
    assert code == 2
    assert len(err) == 1
    assert str(path) in err[0]


def test_a_sea_without_fishes_is_refused(capsys, tmp_path):
    text = resource_path("assets/scenarios/peaceful.toml").read_text()
    path = tmp_path / "empty.toml"
    path.write_text(re.sub(r"(?m)^number = \d+", "number = 0", text))
    out = str(tmp_path / "x.h5")
    code, _, err = run(capsys, "simulate", "--ticks", "1", "--out", out, "--scenario", str(path))
    assert code == 2
    assert len(err) == 1
    assert str(path) in err[0]


@pytest.mark.parametrize(
    ("command", "out"),
    [
        (["film"], "new/folder/x.mp4"),
        (["film"], "new/frames"),
        (["simulate", "--ticks", "5", "--out"], "new/x.h5"),
        (["benchmark", "--json"], "new/x.json"),
    ],
)
def test_a_command_that_fails_makes_no_folder(capsys, tmp_path, command, out):
    code, _, err = run(capsys, *command, str(tmp_path / out), "--scenario", "typo")
    assert code == 2
    assert len(err) == 1
    assert not list(tmp_path.iterdir())


def test_the_front_door_is_the_dive():
    done = subprocess.run(
        [sys.executable, str(DOOR), "--sise", "1x1"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert (
        done.stderr == "subsea: unknown option of `subsea dive`: '--sise'; did you mean '--size'?\n"
    )


def test_a_missing_package_is_one_line():
    """Before `make` was run: here, a Python without its site-packages."""
    done = subprocess.run(
        [sys.executable, "-S", str(DOOR)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "make run" in done.stderr


def test_the_module_is_the_command():
    done = subprocess.run(
        [sys.executable, "-m", "subsea", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("subsea ")
