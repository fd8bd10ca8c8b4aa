import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from capture.cli import record as record_command
from capture.cli.main import main
from capture.inspection import simulated
from capture.recording import record
from subsea.fish.species import load_species
from subsea.repertoire import read_repertoire, write_repertoire
from subsea.repertoire.files import READABLE
from subsea.repertoire.schema import VERSION
from tests.support.commands import refusal
from tests.support.recording import known_turn

pytestmark = pytest.mark.usefixtures("known_turns")


def refused(words, capsys, code=2):
    """Run a command that is refused, and return its line."""
    line = refusal(main, words, capsys, code)
    assert line.startswith("subsea-capture: ")
    return line


@pytest.mark.nightly
def test_a_recording_can_be_read_and_repeats_to_the_last_byte(tmp_path):
    for folder in ("one", "two"):
        known_turn.cache_clear()
        assert main(["record", "moon_wrasse", "--out", str(tmp_path / folder)]) == 0
    one, two = (tmp_path / folder / "moon_wrasse.h5" for folder in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()
    expected = record.segments_of(load_species("moon_wrasse"))
    assert read_repertoire(one).recorded_names() == list(expected)


def test_wrong_commands_are_errors_of_one_line_with_code_2(recorded, capsys):
    for arguments, expected in (
        (["recrod"], "did you mean 'record'?"),
        (["record", "fusiler"], "did you mean 'fusilier'?"),
        (["record"], "name a species"),
        (["record", "fusilier", "--jobs", "0"], "whole number from 1"),
        (["record", "fusilier", "--jobs", "many"], "whole number from 1"),
        (["record", "--speed"], "--speed"),
        (["record", "fusilier", "--all"], "'fusilier'"),
        (["record", "fusilier", "--out", "/etc/passwd"], "/etc/passwd"),
        (["record", "fusilier", "--out", "/etc/passwd/new"], "/etc/passwd/new"),
        (["record", "fusilier", "--out", "/proc"], "/proc"),
        (["inspect"], "SPECIES"),
        (["inspect", "no/such.h5"], "no such file"),
        (["plot", "no/such.h5", "--out", "x"], "no such file"),
        (["plot", "no/such.h5"], "--out"),
        (["plot", str(recorded), "--out", "/proc/plots"], "/proc/plots: cannot make the folder"),
    ):
        assert expected in refused(arguments, capsys)


@pytest.mark.parametrize(
    ("command", "name", "noun"),
    [
        ("record fusilier", "fusilier.h5", "a repertoire"),
        ("plot RECORDED", "fusilier.png", "a PNG picture"),
        ("mesh RECORDED fish.obj --fit", "fish_swim_fast_0003.obj", "a Wavefront OBJ mesh"),
        ("learn fusilier", "", "a species"),
        ("export fusilier --to gltf", "fusilier.glb", "a glTF file (.glb)"),
        ("export fusilier --to vat", "fusilier_vat/fusilier_vat.png", "a PNG picture"),
        ("export fusilier --to usd", "fusilier.usdc", "a USD stage (.usdc)"),
    ],
)
def test_a_file_of_another_kind_is_not_replaced(recorded, tmp_path, capsys, command, name, noun):
    obj = tmp_path / "fish.obj"
    obj.write_text("v 0 0 0\nv 1 1 0\nv 1 0 1\nf 1 2 3\n")
    notes = tmp_path / "out" / name
    notes.parent.mkdir(exist_ok=True, parents=True)
    notes.write_text("my notes")
    words = command.replace("RECORDED", str(recorded)).replace("fish.obj", str(obj)).split()
    expected = f"{notes}: exists and is not {noun}; choose another name or give --force"
    fault = refused([*words, "--out", str(tmp_path / "out")], capsys)
    assert fault == f"subsea-capture: {expected}\n"
    assert notes.read_text() == "my notes"
    assert [path for path in (tmp_path / "out").rglob("*") if path.is_file()] in ([notes], [])


def test_recording_warns_of_turns_that_go_the_wrong_way(recorded, tmp_path, capsys):
    good = read_repertoire(recorded)
    wrong = {"turn_left_sharp": good.segments["turn_right_sharp"]}
    path = tmp_path / "fusilier.h5"
    write_repertoire(path, replace(good, segments=good.segments | wrong))
    assert main(["record", "fusilier", "--out", str(tmp_path)]) == 0
    first, warning = capsys.readouterr().out.splitlines()
    assert first == f"{path}: up to date"
    assert warning.startswith("  warning: A sharp turn to the left turns the wrong way, by 89°.")


def test_an_installed_package_is_not_written_into(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(record, "make_segment", pytest.fail)  # the folder is checked first
    monkeypatch.setattr(record_command, "resource_path", lambda name: tmp_path / name)
    assert "--out" in refused(["record", "fusilier"], capsys)
    assert not list(tmp_path.iterdir())


@pytest.fixture
def copy(recorded, tmp_path):
    """A repertoire file of the fusilier to damage."""
    return Path(shutil.copy(recorded, tmp_path / "copy.h5"))


def test_damaged_and_newer_files_are_errors_of_one_line(copy, tmp_path, capsys):
    def fails(*words):
        for command in (["inspect", str(copy)], ["plot", str(copy), "--out", str(tmp_path)]):
            line = refused(command, capsys)
            assert all(word in line for word in ("copy.h5", *words))

    with h5py.File(copy, "a") as file:
        file.attrs["version"] = 7
    fails(f"version 7, this program reads versions {READABLE[0]} to {VERSION}; update subsea")
    hdf5, truncated = b"\x89HDF\r\n\x1a\n" + bytes(64), copy.read_bytes()[:20_000]
    for contents in (b"", b"not HDF5 at all", hdf5, truncated):
        copy.write_bytes(contents)
        fails()
    with h5py.File(copy, "w") as file:
        file["weather"] = [1.0, 2.0]
    fails("not a repertoire")


def test_missing_plans_and_segments_are_reported(copy, capsys):
    with h5py.File(copy, "a") as file:
        file.attrs["provenance"] = np.bytes_("{}")
    assert main(["inspect", str(copy)]) == 2
    out, err = capsys.readouterr()
    assert "swim_fast" in out and "provenance" in err and err.count("\n") == 1
    with h5py.File(copy, "a") as file:
        del file["segments/swim_slow"]
    assert main(["inspect", str(copy)]) == 1
    assert "no swim_slow" in capsys.readouterr().out


@pytest.fixture
def quick(monkeypatch):
    """Costs as on a machine that does nothing else."""
    monkeypatch.setattr(simulated, "step_cost", lambda *_: 3.0)
    monkeypatch.setattr(simulated, "replay_cost", lambda *_: 0.05)
    monkeypatch.setattr(simulated, "frame_cost", lambda *_: 0.02)


def test_inspect_shows_segments_and_measures(recorded, quick, capsys):
    assert main(["inspect", str(recorded)]) == 0  # though aims are missed
    out = capsys.readouterr().out
    assert "turn_right_sharp" in out
    assert "simulating again" in out
    assert "Strouhal" in out
    rows = {line[:41].strip(): " ".join(line[41:].split()) for line in out.splitlines()}
    assert rows["replay of a body frame"] == "0.020 µs ≤ 0.03 µs pass ≤ 0.01 µs missed"
    assert "FALLS SHORT" not in out


@pytest.mark.nightly
def test_a_fish_that_misses_a_target_is_code_1(copy, quick, capsys):
    """The same file, but its sharp turn claims to be one of 20° more."""
    with h5py.File(copy, "a") as file:
        file["segments/turn_left_sharp"].attrs["turn_deg"] += 20.0
    assert main(["inspect", str(copy)]) == 1
    short = [line for line in capsys.readouterr().out.splitlines() if "FALLS SHORT" in line]
    assert [line.split("  ")[0] for line in short] == ["recorded turn of 90°"]


def test_an_interrupted_recording_leaves_nothing(tmp_path, monkeypatch, capsys):
    calls = []

    def interrupted(*arguments, **options):
        calls.append(arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr(record, "make_segment", interrupted)
    fault = refused(["record", "fusilier", "--out", str(tmp_path)], capsys, 130)
    assert calls and fault.startswith("subsea-capture: interrupted")
    assert not list(tmp_path.iterdir())


def test_help_lists_commands_and_gives_examples(capsys):
    assert main([]) == 0
    listed = capsys.readouterr().out
    for command in ("record", "learn", "inspect", "plot", "mesh", "export"):
        assert f"\n  {command} " in listed
        with pytest.raises(SystemExit) as done:
            main([command, "--help"])
        assert done.value.code == 0
        assert f"subsea-capture {command}" in capsys.readouterr().out.split("examples:")[1]
