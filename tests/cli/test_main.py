"""The command line as a shell sees it: exit codes, one line for every fault, examples."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from subsea import __version__
from subsea.base.system import resource_path
from subsea.cli.main import main
from subsea.media.record import read_record
from subsea.scenario.load import own_scenarios

COMMANDS = (
    "dive", "export", "film", "logbook", "benchmark", "convert", "dataset", "simulate", "soak",
    "study", "sweep", "build", "skin", "fleet", "keys", "list", "show", "theatre", "doctor",
    "settings",
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
    assert not err
    listed = [
        line.split()[0]
        for line in out.splitlines()
        if line.startswith("  ") and "-" not in line.split()[0]
    ]
    assert listed == [*COMMANDS]
    for title in ("dive and film:\n  dive ", "this machine:\n  doctor "):
        assert title in out


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
    heavy |= {"asyncio", "ssl"}
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
    (["study", "--seeds", "1-2"], "--seeds needs --validate"),
    (["study", "--validate", "--out", "plots"], "give --plots"),
    (["study", "--validate", "peacefull"], "'peaceful'"),
    (["study", "--validate", "--seeds", "2-1"], "such as 1:64"),
    (["study", "--validate", "--report", "/proc/none/a.md"], "/proc/none"),
    (["study", "nowhere.h5"], "subsea: nowhere.h5: no such file"),
    (["study", "/tmp"], "subsea: /tmp: cannot read (it is a folder)"),
    (["study", "a" * 300], "too long"),
    (["sweep", "peaceful", "--ticks", "5", "--out", "a"], "--seeds"),
    (["sweep", "peaceful", "--seeds", "5:1", "--ticks", "5", "--out", "a"], "such as 1:64"),
    (["sweep", "peacefull", "--seeds", "1", "--ticks", "5", "--out", "a"], "'peaceful'"),
    (
        ["sweep", "peaceful", "--seeds", "1", "--ticks", "5", "--out", "a", "--set", "seed=1,2"],
        "give the seeds with --seeds",
    ),
    (["sweep", "peaceful", "--seeds", "1", "--ticks", "5", "--out", "/proc/a"], "/proc/a"),
    (["theatre", "nowhere.toml"], "subsea: nowhere.toml: no such file"),
    (["skin", "no.jpg", "--auto", "--species", "clownfish"], "subsea: no.jpg: no such file"),
    (["benchmark", "--compare", "no.json"], "subsea: no.json: no such file"),
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
    (["dive", "--theatre", "three-projectors", "--display", "headset"], "--display headset"),
    (["film", "a.mp4", "--display", "headset"], "--display headset is for a dive"),
    (["dive", "--no-resume"], "--no-resume needs --theatre and --node too"),
    (["keys", "here", "../left"], "expected a name"),
    (["dive", "--settings", "nowhere/mine.toml"], "nowhere/mine.toml: no such file"),
    (["settings", "--writ"], "'--write'"),
    (["list"], "WHAT"),
    (["list", "specie"], "WHAT 'specie': unknown choice; did you mean 'species'?"),
    (["dive", "--look", "x"], "--look 'x': unknown choice; there are: colours, identity, range"),
    (["simulate", "--ticks", "5", "--seconds", "1", "--out", "a.h5"], "not allowed with"),
    (["simulate", "--seconds", "0.01", "--out", "a.h5"], "from 0.033"),
    (["film", "a.png", "--fish", "3", "--follow", "40"], "no fish 40: expected 0 to 2"),
    (["film", "a/", "--fish", "3", "--eyes", "40"], "no fish 40: expected 0 to 2"),
]


def test_every_fault_is_one_line_with_a_hint(capsys):
    for arguments, hint in FAULTS:
        code, out, err = run(capsys, *arguments)
        assert code == 2, arguments
        assert not out, arguments
        assert len(err) == 1, err
        assert hint in err[0], arguments


PEACEFUL = resource_path("assets/scenarios/peaceful.toml").read_text()


@pytest.mark.parametrize(
    "text",
    [
        "", "title = 3", "seed = [", 'title = "x"\nunknown = 1',
        re.sub(r"(?m)^number = \d+", "number = 0", PEACEFUL),
    ],
    ids=["empty", "wrong type", "not TOML", "unknown key", "no fishes"],
)  # fmt: skip
def test_a_faulty_scenario_file_is_named(capsys, tmp_path, text):
    path = tmp_path / "reef.toml"
    path.write_text(text)
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


@pytest.mark.parametrize(
    ("command", "noun"),
    [
        (["film", "notes.mp4"], "an MP4 film"),
        (["film", "notes.png"], "a PNG picture"),
        (["film", "a.mp4", "--theatre", "three-projectors"], "an MP4 film"),
        (["simulate", "--ticks", "5", "--out", "notes.h5"], "a record"),
        (["study", "run.h5", "--json", "notes.json"], "a report of `subsea study`"),
        (["benchmark", "--json", "notes.json"], "a report of `subsea benchmark`"),
        (["benchmark", "--csv", "notes.csv"], "a table of `subsea benchmark`"),
        (["benchmark", "--plot", "notes.png"], "a PNG picture"),
        (["soak", "--json", "notes.json"], "a report of `subsea soak`"),
        (["skin", "a.jpg", "--auto", "--species", "fusilier", "--out", "notes.png"],
         "a PNG picture"),
    ],
)  # fmt: skip
def test_a_file_of_another_kind_is_not_replaced(capsys, tmp_path, monkeypatch, command, noun):
    monkeypatch.chdir(tmp_path)
    names = [word for word in command if word.startswith("notes")] or ["a-middle.mp4"]
    Path(names[0]).write_text("my notes")
    expected = f"subsea: {names[0]}: exists and is not {noun}; choose another name or give --force"
    assert run(capsys, *command) == (2, "", [expected])
    assert Path(names[0]).read_text() == "my notes"
    assert [path.name for path in tmp_path.iterdir()] == names


def test_force_replaces_any_file(capsys, tmp_path):
    out = tmp_path / "run.h5"
    out.write_text("my notes")
    assert (
        run(capsys, "simulate", "--ticks", "2", "--fish", "3", "--out", str(out), "--force")[0] == 0
    )
    assert read_record(out).alive.shape == (2, 3)


def test_seconds_are_rounded_to_ticks(capsys, tmp_path):
    out = tmp_path / "run.h5"
    code, printed, err = run(
        capsys, "simulate", "--seconds", "0.1", "--fish", "3", "--out", str(out)
    )
    assert (code, printed) == (0, f"{out}: 3 ticks of 3 fishes\n")
    assert err[0] == "subsea: 0.1 s are 3 ticks of 0.033 s"
    assert read_record(out).alive.shape == (3, 3)


def test_run_submarine_is_the_dive():
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


@pytest.mark.parametrize("module", ["subsea", "capture"])
def test_both_programs_print_the_version(module):
    done = subprocess.run(
        [sys.executable, "-m", module, "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"subsea {__version__}\n"


def test_files_are_listed_with_titles_and_faults(capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    own = own_scenarios()
    own.mkdir(parents=True)
    (own / "mine.toml").write_text(PEACEFUL.replace('title = "Peaceful bay"', 'title = "My bay"'))
    (own / "torn.toml").write_text("[")
    (own / "peaceful.toml").write_text(PEACEFUL)
    code, out, err = run(capsys, "list", "scenarios")
    rows = {line.split()[0] + " " + line.split()[1]: line for line in out.splitlines()}
    assert code == 0 and not err
    assert rows["peaceful shipped"].endswith("Peaceful bay")
    assert rows["mine own"].endswith("My bay")
    assert f"error: {own}/torn.toml:1: not valid TOML" in rows["torn own"]
    assert rows["peaceful own"].endswith("a shipped file has this name; rename yours")
    assert rows["own files:"].endswith(str(own))
    for what, name, title in (
        ("species", "clownfish", "Ocellaris clownfish"),
        ("theatres", "dome", "A dome with one fisheye projector"),
    ):
        found = json.loads(run(capsys, "list", what, "--json")[1])
        expected = {"name": name, "origin": "shipped", "title": title, "fault": None}
        assert expected in found
