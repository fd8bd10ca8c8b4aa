import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from capture.cli.main import main
from capture.inspection import simulated
from capture.recording import record
from subsea.repertoire import read_repertoire
from subsea.repertoire.schema import VERSION


def one_line(capsys: pytest.CaptureFixture[str]) -> str:
    out, err = capsys.readouterr()
    assert not out
    assert err.startswith("subsea-capture: ")
    assert err.count("\n") == 1
    return err


def test_a_recording_can_be_read_and_repeats_to_the_last_byte(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        assert main(["record", "emperor_angelfish", "--out", str(tmp_path / folder)]) == 0
    one, two = (tmp_path / folder / "emperor_angelfish.h5" for folder in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()
    assert len(read_repertoire(one).segments) == 7


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["recrod"], "did you mean 'record'?"),
        (["record", "fusiler"], "did you mean 'fusilier'?"),
        (["record"], "name a species"),
        (["record", "fusilier", "--jobs", "0"], "whole number from 1"),
        (["record", "fusilier", "--jobs", "many"], "whole number from 1"),
        (["record", "--speed"], "--speed"),
        (["inspect"], "SPECIES"),
        (["inspect", "no/such.h5"], "no such file"),
        (["plot", "no/such.h5", "--out", "x"], "no such file"),
        (["plot", "no/such.h5"], "--out"),
    ],
)
def test_a_wrong_command_is_an_error_of_one_line_with_code_2(
    arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert expected in one_line(capsys)


@pytest.mark.parametrize("command", ["inspect", "plot"])
def test_a_damaged_file_is_one_line(
    command: str, recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "damaged.h5"
    extra = ["--out", str(tmp_path)] if command == "plot" else []
    hdf5, truncated = b"\x89HDF\r\n\x1a\n" + bytes(64), recorded.read_bytes()[:20_000]
    for contents in (b"", b"not HDF5 at all", hdf5, truncated):
        path.write_bytes(contents)
        assert main([command, str(path), *extra]) == 2
        assert "damaged.h5" in one_line(capsys)
    with h5py.File(path, "w") as file:
        file["weather"] = [1.0, 2.0]
    assert main([command, str(path), *extra]) == 2
    assert "not a repertoire" in one_line(capsys)


def test_a_repertoire_of_a_newer_version_is_one_line_with_what_to_do(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "newer.h5"
    path.write_bytes(recorded.read_bytes())
    with h5py.File(path, "a") as file:
        file.attrs["version"] = 7
    for command in (["inspect", str(path)], ["plot", str(path), "--out", str(tmp_path)]):
        assert main(command) == 2
        line = one_line(capsys)
        assert f"version 7, this program reads version {VERSION}; update subsea" in line


def test_an_unwritable_folder_is_an_error_before_plotting(
    recorded: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["plot", str(recorded), "--out", "/proc/plots"]) == 2
    assert "/proc/plots: cannot make the folder" in one_line(capsys)


def test_a_provenance_without_plans_is_an_error_after_the_table(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "orphan.h5"
    path.write_bytes(recorded.read_bytes())
    with h5py.File(path, "a") as file:
        file.attrs["provenance"] = np.bytes_("{}")
    assert main(["inspect", str(path)]) == 2
    out, err = capsys.readouterr()
    assert "swim_fast" in out
    assert "provenance" in err
    assert err.count("\n") == 1


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Costs as on a machine that does nothing else."""
    monkeypatch.setattr(simulated, "step_cost", lambda *_: 3.0)
    monkeypatch.setattr(simulated, "replay_cost", lambda *_: 0.05)
    monkeypatch.setattr(simulated, "frame_cost", lambda *_: 0.02)


def test_inspect_shows_segments_and_measures(
    recorded: Path, quick: None, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", str(recorded)]) == 0  # though aims are missed
    out = capsys.readouterr().out
    assert "turn_right_sharp" in out
    assert "simulating again" in out
    assert "Strouhal" in out
    rows = {line[:41].strip(): " ".join(line[41:].split()) for line in out.splitlines()}
    assert rows["replay of a body frame"] == "0.020 µs ≤ 0.03 µs pass ≤ 0.01 µs missed"
    assert "FALLS SHORT" not in out


def test_a_fish_that_misses_a_target_is_code_1(
    recorded: Path, quick: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same file, but its fish holds a bend of 30° for as long as one of 60°."""
    path = tmp_path / "astray.h5"
    path.write_bytes(recorded.read_bytes())
    with h5py.File(path, "a") as file:
        provenance = json.loads(file.attrs["provenance"])
        rows = provenance["turn"]["steering"]
        rows[0]["hold_ticks"] = rows[2]["hold_ticks"]
        file.attrs["provenance"] = np.bytes_(json.dumps(provenance).encode())
    assert main(["inspect", str(path)]) == 1
    short = [line for line in capsys.readouterr().out.splitlines() if "FALLS SHORT" in line]
    assert [line.split(",")[0] for line in short] == ["turn of 30°", "turn of 30°"]


def test_an_incomplete_repertoire_is_code_1(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "gap.h5"
    path.write_bytes(recorded.read_bytes())
    with h5py.File(path, "a") as file:
        del file["segments/swim_slow"]
    assert main(["inspect", str(path)]) == 1
    assert "no swim_slow" in capsys.readouterr().out


def test_an_interrupted_recording_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls = []

    def interrupted(*arguments: object, **options: object) -> None:
        calls.append(arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr(record, "make_segment", interrupted)
    assert main(["record", "fusilier", "--out", str(tmp_path)]) == 130
    assert calls
    assert not list(tmp_path.iterdir())
    assert one_line(capsys).startswith("subsea-capture: interrupted")


def test_help_lists_commands_and_gives_examples(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    listed = capsys.readouterr().out
    for command in ("record", "learn", "inspect", "plot", "mesh", "export"):
        assert f"    {command} " in listed
        with pytest.raises(SystemExit) as done:
            main([command, "--help"])
        assert done.value.code == 0
        assert f"subsea-capture {command}" in capsys.readouterr().out.split("examples:")[1]
