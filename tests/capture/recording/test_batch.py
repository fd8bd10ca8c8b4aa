"""Recording of several species: interrupted, resumed, in processes that die, on a full disk."""

import dataclasses
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

from capture.cli.main import main
from capture.recording import batch
from capture.recording.batch import (
    finished_segments,
    process_pool,
    record_all,
    save_segment,
    serial,
)
from capture.recording.record import record_segment, segments_of
from subsea.base import hdf5
from subsea.base.errors import UserError
from subsea.fish.species import load_species, species_names
from subsea.repertoire import write_repertoire
from subsea.repertoire.schema import FORMAT
from tests.support.commands import full_disk, refusal
from tests.support.daily import only
from tests.support.recording import each_once

pytestmark = pytest.mark.usefixtures("known_turns")

NAMES = ["emperor_angelfish", "fusilier"]
EACH, OTHERS = (segments_of(load_species(name)) for name in reversed(NAMES))
WHOLE = len(OTHERS)  # segments of the first species


@pytest.fixture(scope="module")
def whole(repertoires, tmp_path_factory):
    """A folder with the files of an undisturbed recording."""
    folder = tmp_path_factory.mktemp("whole")
    for name in NAMES:
        write_repertoire(folder / f"{name}.h5", repertoires[name])
    return folder


def assert_same(folder, whole):
    """The same files, to the last byte, and nothing beside them."""
    assert sorted(path.name for path in folder.iterdir()) == [f"{name}.h5" for name in NAMES]
    for name in NAMES:
        assert (folder / f"{name}.h5").read_bytes() == (whole / f"{name}.h5").read_bytes()


def changed(species, table, **values):
    """The species with other values in one of its tables."""
    return structs.replace(species, **{table: structs.replace(getattr(species, table), **values)})


@pytest.fixture(scope="module")
def known(segments):
    """Segments that tests have swum."""
    return {
        f"{segment} of {load_species(name)}": recorded
        for name, found in segments.items()
        for segment, recorded in found.items()
    }


@pytest.fixture
def swum(monkeypatch, known):
    """The segments that are swum, in their order; each is simulated once for all tests."""
    names: list[str] = []
    record = each_once(known)

    def swim(species, segment):
        names.append(segment)
        return record(species, segment)

    monkeypatch.setattr(batch, "record_segment", swim)
    return names


@pytest.mark.parametrize("done", only([WHOLE], [4, WHOLE, WHOLE + len(EACH)]))
def test_an_interrupted_recording_continues_where_it_stopped(done, whole, tmp_path, swum):
    def interrupt():
        if len(swum) == done:
            raise KeyboardInterrupt

    finished = (done >= WHOLE) + (done == WHOLE + len(EACH))
    if finished < 2:
        with pytest.raises(KeyboardInterrupt):
            record_all(dict.fromkeys(NAMES, tmp_path), serial, check=interrupt)
    else:
        record_all(dict.fromkeys(NAMES, tmp_path), serial, check=interrupt)
    assert [path.name for path in tmp_path.glob("*.h5")] == [f"{n}.h5" for n in NAMES[:finished]]
    recorded = record_all(dict.fromkeys(NAMES, tmp_path), serial)
    assert recorded == NAMES[finished:]
    assert swum == [*OTHERS, *EACH]
    assert_same(tmp_path, whole)


def test_an_up_to_date_repertoire_is_skipped_unless_forced(whole, tmp_path, swum, capsys):
    path = tmp_path / "fusilier.h5"
    path.write_bytes((whole / "fusilier.h5").read_bytes())
    before = path.stat().st_mtime_ns
    assert main(["record", "fusilier", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"{path}: up to date\n"
    assert path.stat().st_mtime_ns == before
    assert not swum
    assert main(["record", "fusilier", "--out", str(tmp_path), "--force"]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    assert path.stat().st_mtime_ns > before
    assert swum == list(EACH)


def test_damaged_segments_and_those_of_another_fish_are_recorded_again(tmp_path, swum):
    species = load_species("fusilier")
    recorded = record_segment(species, "swim_slow")
    swims = ("swim_slow", "swim_medium", "swim_fast")
    for segment in swims:
        save_segment(tmp_path, "fusilier", species, segment, recorded)
    assert set(finished_segments(tmp_path, "fusilier", species)) == set(swims)
    assert not finished_segments(tmp_path, "fusilier", changed(species, "swim", lag=1.4))
    ours, theirs = (tmp_path / f".{fish}.swim_fast.recording" for fish in ("fusilier", "bluefish"))
    theirs.write_bytes(ours.read_bytes())
    assert not finished_segments(tmp_path, "bluefish", species)
    (tmp_path / ".fusilier.swim_medium.recording").write_bytes(b"half")
    assert set(finished_segments(tmp_path, "fusilier", species)) == {"swim_slow", "swim_fast"}


@pytest.mark.parametrize("name", only(NAMES, species_names()))
def test_a_segment_is_saved_exactly(name, tmp_path):
    species = load_species(name)
    recorded = record_segment(species, "turn_left_sharp")
    segment = recorded.segment
    save_segment(tmp_path, name, species, "turn_left_sharp", recorded)
    ((back, *numbers),) = finished_segments(tmp_path, name, species).values()
    assert numbers == [recorded.warm_up_beats, recorded.bend]
    for field in dataclasses.fields(segment):
        ours, theirs = getattr(segment, field.name), getattr(back, field.name)
        if field.name == "control_points" and ours is not None:
            ours = ours.astype(np.float32)  # as they are stored
        np.testing.assert_array_equal(theirs, ours)


@pytest.mark.nightly
def test_neither_two_processes_nor_a_crash_of_one_change_the_files(whole, tmp_path, save_turns):
    saved = [save_turns(name, tmp_path) for name in NAMES]
    killed: list[int] = []
    told: list[tuple[str, int]] = []

    def kill_once():
        for child in multiprocessing.active_children()[: 1 - len(killed)]:
            os.kill(child.pid or 0, signal.SIGKILL)
            killed.append(child.pid or 0)

    recorded = record_all(
        dict.fromkeys(NAMES, tmp_path),
        process_pool(2),
        progress=lambda *at: told.append(at),
        check=kill_once,
    )
    assert recorded == NAMES
    assert len(killed) == 1
    assert_same(tmp_path, whole)
    for name, first in zip(NAMES, saved, strict=True):
        counts = [count for which, count in told if which == name]
        assert counts == list(range(first, len(segments_of(load_species(name))) + 1))


def test_repeated_crashes_are_an_error_of_one_line(tmp_path):
    def kill():
        for child in multiprocessing.active_children():
            os.kill(child.pid or 0, signal.SIGKILL)

    with pytest.raises(UserError, match=r"crashed 3 times.*fusilier swim_") as caught:
        record_all({"fusilier": tmp_path}, process_pool(2), check=kill)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_fish_that_cannot_swim_is_named(tmp_path, monkeypatch):
    limp = changed(load_species("fusilier"), "body", cross_stiffness=1.0)
    monkeypatch.setattr(batch, "load_species", lambda name: limp)
    with pytest.raises(UserError, match="fusilier, swim_slow: the body lost its shape"):
        record_all({"fusilier": tmp_path}, serial)
    assert not (tmp_path / "fusilier.h5").exists()


def write_empty(path):
    """Write a repertoire without segments, which is not up to date; return its bytes."""
    with hdf5.writing(path) as file:
        file.attrs["format"] = hdf5.text(FORMAT)
    return path.read_bytes()


@pytest.mark.parametrize("free", [1000, 60_000, 500_000])
def test_a_full_disk_is_one_line_and_leaves_the_old_repertoire(free, tmp_path, swum, capsys):
    """The disk fills up in the first segment, in the fifth, or in the repertoire."""
    old = tmp_path / "fusilier.h5"
    before = write_empty(old)
    with full_disk(free):
        fault = refusal(main, ["record", "fusilier", "--out", str(tmp_path)], capsys)
    assert fault.startswith(f"subsea-capture: {tmp_path}")
    assert fault.endswith("cannot write (File too large)\n")
    assert old.read_bytes() == before
    assert not list(tmp_path.rglob("*.part"))


SLOW = """
import sys, time
from capture.cli import main as cli
from capture.recording import batch
record_segment = batch.record_segment
def slowly(species, segment):
    time.sleep(0.4)
    return record_segment(species, segment)
batch.record_segment = slowly
sys.exit(cli.main(sys.argv[1:]))
"""


@pytest.mark.nightly
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_leaves_the_old_repertoire_and_one_line(number, whole, tmp_path, swum):
    old = tmp_path / "fusilier.h5"
    before = write_empty(old)
    command = [sys.executable, "-c", SLOW, "record", "fusilier", "--out", str(tmp_path)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        while running.poll() is None and not list(tmp_path.glob(".*.swim_medium.recording")):
            time.sleep(0.02)
        running.send_signal(number)
        out, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert not out
    assert err == "subsea-capture: interrupted: run the same command to continue\n"
    assert old.read_bytes() == before
    assert main(["record", "fusilier", "--out", str(tmp_path)]) == 0
    assert old.read_bytes() == (whole / "fusilier.h5").read_bytes()
    assert list(tmp_path.iterdir()) == [old]


@pytest.mark.nightly
def test_ctrl_c_while_processes_start_prints_nothing_else(tmp_path):
    """A terminal sends it to every process of the command."""
    command = [sys.executable, "-m", "capture", "record", "--all", "--jobs", "2"]
    with subprocess.Popen(
        [*command, "--out", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as running:
        children = Path(f"/proc/{running.pid}/task/{running.pid}/children")
        while len(children.read_text().split()) < 3:  # the two, and one that tidies up after them
            assert running.poll() is None
            time.sleep(0.005)
        time.sleep(0.05)
        os.killpg(running.pid, signal.SIGINT)
        out, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert not out
    assert err == "subsea-capture: interrupted: run the same command to continue\n"
