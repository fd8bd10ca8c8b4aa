"""The store of a sweep's results: few files, which survive kills, damage and a full disk."""

import gzip
import os
import subprocess
import sys

import pytest

from subsea.base.errors import UserError
from subsea.lab import run_store as module
from subsea.lab.run_store import JOURNAL, RunStore
from tests.support.commands import full_disk


@pytest.fixture(autouse=True)
def short_shards(monkeypatch):
    monkeypatch.setattr(module, "SHARD_RUNS", 5)


WANTED = {f"run{k}": f"inputs{k}" for k in range(12)}
ROWS = {name: {"share": k / 7, "none": None} for k, name in enumerate(WANTED)}


def fill(folder, names=WANTED):
    store = RunStore(folder, pytest.fail)
    with store.writing():
        for name in names:
            store.add(name, WANTED[name], ROWS[name])


def read(folder, told=None):
    return RunStore(folder, pytest.fail if told is None else told.append).read(WANTED)


def test_results_are_read_as_they_were_written(tmp_path):
    assert read(tmp_path / "none") == {}
    fill(tmp_path / "runs")
    assert read(tmp_path / "runs") == ROWS
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == [
        "00001.jsonl.gz", "00002.jsonl.gz", JOURNAL,
    ]  # fmt: skip


def test_a_thousand_files_hold_far_more_than_a_hundred_thousand_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "SHARD_RUNS", 1000)
    store = RunStore(tmp_path, pytest.fail)
    wanted = {f"{k}": f"i{k}" for k in range(3001)}
    with store.writing():
        for name, inputs in wanted.items():
            store.add(name, inputs, {"share": 0.5})
    assert len(list(tmp_path.iterdir())) == 4
    assert RunStore(tmp_path, pytest.fail).read(wanted).keys() == wanted.keys()


def test_a_result_of_other_inputs_is_not_taken(tmp_path):
    fill(tmp_path)
    changed = WANTED | {"run3": "other"}
    assert RunStore(tmp_path, pytest.fail).read(changed).keys() == WANTED.keys() - {"run3"}


def test_the_latest_of_two_results_counts(tmp_path):
    fill(tmp_path)
    store = RunStore(tmp_path, pytest.fail)
    with store.writing():
        store.add("run1", "inputs1", {"share": 9.0})
    assert read(tmp_path)["run1"] == {"share": 9.0}


@pytest.mark.parametrize("at", [20, 70, -5])
def test_a_damaged_shard_costs_only_its_runs(tmp_path, at, monkeypatch):
    monkeypatch.setattr(module, "PIECE", 8)
    fill(tmp_path)
    shard = tmp_path / "00001.jsonl.gz"
    content = bytearray(shard.read_bytes())
    content[at] ^= 0xFF
    shard.write_bytes(content)
    told = []
    store = RunStore(tmp_path, told.append)
    rows = store.read(WANTED)
    assert told == [f"{shard}: damaged; the runs that it has lost are made again"]
    assert rows.keys() >= {f"run{k}" for k in range(5, 12)}
    assert all(ROWS[name] == row for name, row in rows.items())
    with store.writing():
        for name in WANTED.keys() - rows.keys():
            store.add(name, WANTED[name], ROWS[name])
    assert read(tmp_path) == ROWS  # and no word of damage


def test_a_shard_that_is_cut_short_keeps_its_beginning(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "PIECE", 1)
    fill(tmp_path)
    shard = tmp_path / "00001.jsonl.gz"
    shard.write_bytes(shard.read_bytes()[:-30])
    rows = read(tmp_path, told := [])
    assert len(told) == 1
    assert "run0" in rows and len(rows) < len(WANTED)


def test_a_line_that_is_torn_or_changed_is_left_out(tmp_path):
    fill(tmp_path)
    journal = tmp_path / JOURNAL
    content = journal.read_bytes()
    journal.write_bytes(content.replace(b"inputs10", b"inputs19") + content[:30])
    store = RunStore(tmp_path, (told := []).append)
    assert store.read(WANTED).keys() == WANTED.keys() - {"run10"}
    assert len(told) == 1
    with store.writing():
        assert journal.read_bytes() == b""
    assert read(tmp_path).keys() == WANTED.keys() - {"run10"}


def test_nothing_is_lost_between_a_shard_and_an_empty_journal(tmp_path):
    """As if the process had been killed after the shard was written."""
    fill(tmp_path, list(WANTED)[:4])
    journal = (tmp_path / JOURNAL).read_bytes()
    fill(tmp_path, ["run4"])
    (tmp_path / JOURNAL).write_bytes(journal)
    assert read(tmp_path).keys() == set(list(WANTED)[:5])
    fill(tmp_path, list(WANTED)[5:])
    assert read(tmp_path) == ROWS


def test_a_full_disk_keeps_all_earlier_results(tmp_path):
    store = RunStore(tmp_path, pytest.fail)
    with store.writing():
        store.add("run0", "inputs0", ROWS["run0"])
        free = (tmp_path / JOURNAL).stat().st_size + 10
        with full_disk(free), pytest.raises(UserError, match=r"cannot write \(File too") as fault:
            store.add("run1", "inputs1", ROWS["run1"])
        assert "\n" not in str(fault.value)
        store.add("run2", "inputs2", ROWS["run2"])
    assert read(tmp_path).keys() == {"run0", "run2"}


def test_a_second_sweep_waits_for_the_first(tmp_path):
    pytest.importorskip("fcntl")
    with (
        RunStore(tmp_path, pytest.fail).writing(),
        pytest.raises(UserError, match="another sweep writes to this folder"),
        RunStore(tmp_path, pytest.fail).writing(),
    ):
        pass
    fill(tmp_path)


def test_a_killed_process_keeps_what_it_has_added(tmp_path):
    program = (
        "import os, pathlib, signal, sys; from subsea.lab.run_store import RunStore\n"
        "store = RunStore(pathlib.Path(sys.argv[1]), print)\n"
        "with store.writing():\n"
        "    for k in range(3):\n"
        "        store.add(f'run{k}', f'inputs{k}', {'share': k / 7, 'none': None})\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=False)
    assert done.returncode < 0
    assert read(tmp_path) == {name: ROWS[name] for name in ("run0", "run1", "run2")}


def test_shards_of_equal_results_are_equal_bytes(tmp_path):
    fill(tmp_path / "a")
    fill(tmp_path / "b")
    for path in (tmp_path / "a").iterdir():
        assert (tmp_path / "b" / path.name).read_bytes() == path.read_bytes()
    assert gzip.decompress((tmp_path / "a/00001.jsonl.gz").read_bytes()).count(b"\n") == 5
    assert os.access(tmp_path / "a" / JOURNAL, os.R_OK)
