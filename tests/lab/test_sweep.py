"""Sweeps: their values, runs and tables."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pyarrow
import pytest
from distributed import Client, LocalCluster
from pyarrow import parquet

import subsea
from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.jobs import dask_cluster
from subsea.jobs.dask_cluster import dask_pool
from subsea.jobs.workers import serial
from subsea.lab import sweep as module
from subsea.lab.comparison import flat_measures
from subsea.lab.own_measures import own_measures
from subsea.lab.report import measure
from subsea.lab.run_store import RunStore
from subsea.lab.sweep import (
    Sweep,
    columns_of,
    make_run,
    read_seeds,
    read_values,
    split_values,
    sweep,
    write_csv,
    write_parquet,
)
from subsea.media.record import read_record
from tests.support.scenes import BARE


@pytest.mark.parametrize(
    ("text", "seeds"),
    [("1:4", (1, 2, 3, 4)), ("7", (7,)), ("1,5, 9:10", (1, 5, 9, 10)), ("0:0", (0,))],
)
def test_seeds(text, seeds):
    assert read_seeds(text) == seeds


@pytest.mark.parametrize(
    "text", ["", "a", "4:1", "-1", "1:", "1,1", "1:2:3", "4294967296", "0:1000000"]
)
def test_faulty_seeds_are_one_line(text):
    with pytest.raises(UserError, match="--seeds") as fault:
        read_seeds(text)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2.5", ("1", "2.5")),
        ("[1,2],[3, 4]", ("[1,2]", "[3, 4]")),
        ("{ a = 1, b = [2, 3] }, {}", ("{ a = 1, b = [2, 3] }", "{}")),
        ('"a,b",c', ('"a,b"', "c")),
        (r'"a\",b",c', (r'"a\",b"', "c")),
        (r"'a\',b", (r"'a\'", "b")),
        ("[1,", ("[1,",)),
        ("a,", ("a", "")),
    ],
)
def test_commas_in_brackets_and_quotes_belong_to_a_value(text, values):
    assert split_values(text) == values


def test_values_of_several_keys():
    found = read_values(["fish.0.number=1,2", " nature.keen = 0.4"])
    assert found == {"fish.0.number": ("1", "2"), "nature.keen": ("0.4",)}


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["fish.0.number"], "expected KEY=VALUE,VALUE"),
        (["a=1,"], "expected KEY=VALUE,VALUE"),
        (["a=1", "a=2"], "is given twice"),
        (["a=1,1"], "a value is there twice"),
        (["seed=1,2"], "--seeds"),
    ],
)
def test_faulty_values_are_one_line(settings, words):
    with pytest.raises(UserError, match=words):
        read_values(settings)


LINES = [
    {"run": "a", "seed": 1, "n": "3", "x": "1", "on": "true", "ticks": 9, "sea.share": 0.5},
    {"run": "b", "seed": 2, "n": "4", "x": "2.5", "on": "false", "ticks": 9, "more": 1.0},
]


def test_values_become_numbers_if_all_of_a_column_are():
    columns = columns_of(LINES)
    assert columns["n"] == [3, 4]
    assert columns["x"] == [1.0, 2.5]
    assert columns["on"] == [True, False]
    assert columns["more"] == [None, 1.0]
    words = [{"p": "[1, 2]", "k": "1"}, {"p": "[3, 4]", "k": "true"}]
    assert columns_of(words) == {"p": ["[1, 2]", "[3, 4]"], "k": ["1", "true"]}


def test_both_files_have_the_columns(tmp_path):
    for write in (write_csv, write_parquet):
        write(tmp_path / write.__name__, LINES)
    text = (tmp_path / "write_csv").read_text()
    assert text == (
        "run,seed,n,x,on,ticks,sea.share,more\na,1,3,1.0,True,9,0.5,\nb,2,4,2.5,False,9,,1.0\n"
    )
    table = parquet.read_table(tmp_path / "write_parquet")
    assert table.to_pydict() == columns_of(LINES)
    types = {name: str(table.schema.field(name).type) for name in table.column_names}
    assert types == {
        "run": "string", "seed": "int64", "n": "int64", "x": "double", "on": "bool",
        "ticks": "int64", "sea.share": "double", "more": "double",
    }  # fmt: skip


def test_no_run_is_an_empty_table(tmp_path):
    write_csv(tmp_path / "a.csv", [])
    write_parquet(tmp_path / "a.parquet", [])
    assert parquet.read_table(tmp_path / "a.parquet").num_rows == 0
    assert pyarrow.__version__


OPTIONS = Sweep(str(BARE), (1, 2), 2, values={"fish.1.number": (1, "2")})
COMMAND = ["sweep", str(BARE), "--seeds", "1:2", "--ticks", "2", "--set", "fish.1.number=1,2"]


def counting(made):
    """A pool that notes the jobs that it gets."""

    def run(work, jobs, check):
        made.append(len(jobs))
        return serial(work, jobs, check)

    return run


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("sweep") / "out"
    assert sweep(OPTIONS, out, csv=True, records=True) == out / "sweep.parquet"
    return out


@pytest.fixture
def copy(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "out")
    return tmp_path / "out"


def test_a_row_for_each_run_in_order(whole):
    rows = parquet.read_table(whole / "sweep.parquet").to_pylist()
    assert [(row["seed"], row["fish.1.number"], row["ticks"]) for row in rows] == [
        (1, 1, 2), (2, 1, 2), (1, 2, 2), (2, 2, 2),
    ]  # fmt: skip
    assert [row["fishes"] for row in rows] == [5.0, 5.0, 6.0, 6.0]
    with (whole / "sweep.csv").open() as file:
        texts = list(csv.DictReader(file))
    assert [row["run"] for row in texts] == [row["run"] for row in rows]
    for row in rows:
        record = read_record(whole / "records" / f"{row['run']}.h5")
        assert record.seed == row["seed"]
        expected = flat_measures(measure(record))
        assert {name: row[name] for name in expected} == expected
    assert sorted(path.name for path in whole.iterdir()) == [
        "records", "runs", "sweep.csv", "sweep.parquet",
    ]  # fmt: skip


@pytest.mark.nightly
def test_the_number_of_processes_changes_no_byte(whole, tmp_path, capsys):
    out = tmp_path / "two"
    assert main([*COMMAND, "--jobs", "2", "--csv", "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}/sweep.parquet\n"
    for name in ("sweep.parquet", "sweep.csv"):
        assert (out / name).read_bytes() == (whole / name).read_bytes()
    assert not (out / "records").exists()


@contextmanager
def local_cluster():
    """A Dask cluster of one thread of this process."""
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp",
        host="127.0.0.1", dashboard_address="127.0.0.1:0",
    ) as cluster:  # fmt: skip
        yield cluster


def test_a_cluster_changes_no_byte(whole, tmp_path, monkeypatch):
    monkeypatch.setattr(dask_cluster, "AHEAD", 3)
    with local_cluster() as cluster:
        pool = dask_pool(cluster.scheduler_address)
        sweep(OPTIONS, tmp_path / "out", pool=pool, records=True)
    for place in ("sweep.parquet", "records", "runs/journal.jsonl"):
        ours, theirs = whole / place, tmp_path / "out" / place
        for path in ours.iterdir() if ours.is_dir() else [ours]:
            assert (theirs / path.relative_to(ours)).read_bytes() == path.read_bytes()


@pytest.mark.nightly
def test_a_program_gives_a_cluster_or_a_client(whole, tmp_path):
    given = {"seeds": (1, 2), "seconds": 0.066, "values": {"fish.1.number": (1, "2")}}
    with local_cluster() as cluster:
        subsea.sweep(str(BARE), tmp_path / "a", cluster=cluster, **given)
        with Client(cluster, set_as_default=False) as client:
            subsea.sweep(str(BARE), tmp_path / "b", cluster=client, **given)
            assert client.status == "running"  # it stays open
    for name in "ab":
        assert (tmp_path / name / "sweep.parquet").read_bytes() == (
            whole / "sweep.parquet"
        ).read_bytes()


def test_what_a_sweep_of_a_program_cannot_be_is_named(tmp_path):
    given = {"seeds": (1,), "seconds": 0.1}
    with pytest.raises(TypeError, match="expected an address, a Dask cluster or client, got 3"):
        subsea.sweep(str(BARE), tmp_path / "a", cluster=3, **given)
    with pytest.raises(ValueError, match="jobs and cluster: give one of the two"):
        subsea.sweep(str(BARE), tmp_path / "a", cluster="tcp://127.0.0.1:9", jobs=2, **given)
    with pytest.raises(UserError, match="cannot import these rules or measures"):
        subsea.sweep(str(BARE), tmp_path / "a", jobs=2, measures=[lambda tick_s: 1.0], **given)
    with pytest.raises(TypeError, match="unexpected keyword 'measure'"):
        subsea.sweep(str(BARE), tmp_path / "a", measure=[farthest_cm], **given)


def test_a_worker_with_other_code_refuses(whole):
    name, job = next(iter(module._jobs(OPTIONS, whole, False)))
    assert make_run(job)[0] == RunStore(whole / "runs", pytest.fail).read({name: job.inputs})[name]
    with pytest.raises(UserError, match="a worker has another version"):
        make_run(job._replace(inputs="0" * 64))


def test_only_what_is_missing_or_differs_is_made_again(copy, monkeypatch, capsys):
    made = []
    before = (copy / "sweep.parquet").read_bytes()
    sweep(OPTIONS, copy, pool=counting(made), records=True)
    assert made == []
    journal = copy / "runs/journal.jsonl"
    left = [copy / ".records.7777777.part", copy / "runs/.00001.jsonl.gz.7777777.part"]
    (left[0] / "tmp").mkdir(parents=True)  # of a process that was killed
    left[1].touch()
    lines = journal.read_bytes().splitlines(keepends=True)
    journal.write_bytes(b"".join([lines[0].replace(b"seconds", b"sceonds"), *lines[2:]]))
    run = json.loads(lines[2][9:])["run"]
    (copy / "records" / f"{run}.h5").unlink()
    sweep(OPTIONS, copy, pool=counting(made), records=True)
    assert made == [3] and not any(path.exists() for path in left)
    assert (
        "journal.jsonl: damaged; the runs that it has lost are made again"
        in capsys.readouterr().err
    )
    assert (copy / "sweep.parquet").read_bytes() == before
    sweep(replace(OPTIONS, seeds=(1, 2, 3), values={"fish.1.number": ("1",)}), copy,
          pool=counting(made))  # fmt: skip
    assert made == [3, 1]
    sweep(replace(OPTIONS, seeds=(1,), values={}, ticks=1), copy, pool=counting(made))
    origin = module.inputs_of
    monkeypatch.setattr(
        module, "inputs_of", lambda *given: origin(*given)._replace(code_sha256="other")
    )
    sweep(OPTIONS, copy, pool=counting(made))
    assert made == [3, 1, 1, 4]


def test_folders_of_earlier_versions_are_read(copy):
    """They have a JSON file for each run."""
    table = (copy / "sweep.parquet").read_bytes()
    journal = copy / "runs/journal.jsonl"
    for line in journal.read_bytes().splitlines():
        result = json.loads(line[9:])
        path = copy / "runs" / f"{result.pop('run')}.json"
        path.write_text(json.dumps(result, indent=1))
    journal.unlink()
    made = []
    sweep(OPTIONS, copy, pool=counting(made), records=True)
    assert made == [] and (copy / "sweep.parquet").read_bytes() == table
    (path := next((copy / "runs").glob("*.json"))).write_text("{}")
    sweep(OPTIONS, copy, pool=counting(made), records=True)
    assert made == [1] and (copy / "sweep.parquet").read_bytes() == table
    path.unlink()
    sweep(OPTIONS, copy, pool=counting(made), records=True)
    assert made == [1]


def test_a_run_that_crashes_is_named_and_the_others_stay(tmp_path, monkeypatch):
    def run(work, jobs, check):
        for k, (job, given) in enumerate(jobs.items()):
            yield job, None if k == 2 else work(given)

    with pytest.raises(UserError, match=r"1 run whose .* \(seed 1 fish.1.number=2\)"):
        sweep(OPTIONS, tmp_path, pool=run)
    assert parquet.read_table(tmp_path / "sweep.parquet").num_rows == 3


def lines_of(out):
    """The number of results in the journal."""
    journal = out / "runs/journal.jsonl"
    return journal.read_bytes().count(b"\n") if journal.is_file() else 0


@pytest.mark.nightly
def test_ctrl_c_keeps_the_finished_runs(tmp_path, capsys):
    out = tmp_path / "out"
    command = [sys.executable, "-m", "subsea", *COMMAND, "--jobs", "1", "--out", str(out)]
    command[command.index("1:2")] = "1:500"
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, process_group=0) as running:
        while not lines_of(out):
            assert running.poll() is None
            time.sleep(0.02)
        os.killpg(running.pid, signal.SIGINT)
        _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    kept = lines_of(out)
    assert f"interrupted: {out}: {kept} run" in err.splitlines()[-1]
    assert err.splitlines()[-1].endswith("kept; run the same command to continue")
    assert [path.name for path in out.iterdir()] == ["runs"]


def test_a_full_disk_is_one_line_and_keeps_what_is_done(tmp_path, monkeypatch):
    def full(store, name, inputs, row):
        if lines_of(tmp_path):
            raise UserError("cannot write (No space left on device)", file=tmp_path)
        add(store, name, inputs, row)

    add = RunStore.add
    monkeypatch.setattr(RunStore, "add", full)
    with pytest.raises(UserError, match="No space left"):
        sweep(OPTIONS, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["runs"]
    assert lines_of(tmp_path) == 1


def test_without_pyarrow_only_csv_works(tmp_path, monkeypatch, whole):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UserError, match=r"Parquet \(without it: --csv\) needs PyArrow: run "):
        sweep(OPTIONS, tmp_path / "none")
    assert not (tmp_path / "none").exists()
    shutil.copytree(whole / "runs", tmp_path / "runs")
    assert sweep(OPTIONS, tmp_path, csv=True) == tmp_path / "sweep.csv"
    assert (tmp_path / "sweep.csv").read_bytes() == (whole / "sweep.csv").read_bytes()
    assert not (tmp_path / "sweep.parquet").exists()


def test_a_foreign_table_stays(tmp_path):
    (tmp_path / "sweep.parquet").write_text("my notes")
    with pytest.raises(UserError, match=r"exists and is not a Parquet table"):
        sweep(OPTIONS, tmp_path)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"values": {"fish.1.numbr": (1, 2)}}, "numbr"),
        ({"values": {"fish.1.number": (1, -2)}}, "fish.1.number=-2"),
        ({"seeds": ()}, "0 runs, expected 1 to"),
        ({"points": ({"fish.1.number": 3},)}, "fish.1.number: has values and points"),
        ({"values": {}, "points": ({"fish.1.number": 1}, {"seed": 3})}, "point 1 of the sweep"),
        ({"values": {"seed": (1, 2)}}, "seed: give the seeds of a sweep"),
    ],
)
def test_faulty_inputs_are_found_before_the_first_run(tmp_path, changed, words):
    made = []
    with pytest.raises(UserError, match=words):
        sweep(replace(OPTIONS, **changed), tmp_path / "out", pool=counting(made))
    assert not made
    assert not Path(tmp_path / "out").exists()


def farthest_cm(position):
    return float(abs(position).max())


def test_points_and_own_measures_are_columns(tmp_path):
    points = (
        {"fish.1.number": 1, "nature.timidity": 0.5},
        {"fish.1.number": 3, "nature.timidity": 2},
    )
    options = replace(
        OPTIONS, seeds=(1,), values={"nature.keen": (0.1, 0.2)}, points=points,
        measures=own_measures([farthest_cm]),
    )  # fmt: skip
    table = parquet.read_table(sweep(options, tmp_path / "out")).to_pydict()
    assert table["nature.keen"] == [0.1, 0.2, 0.1, 0.2]
    assert table["fish.1.number"] == [1, 1, 3, 3]
    assert table["nature.timidity"] == [0.5, 0.5, 2.0, 2.0]
    assert table["fishes"] == [5.0, 5.0, 7.0, 7.0]
    assert min(table["own.farthest_cm"]) > 100.0
    made = []
    sweep(options, tmp_path / "out", pool=counting(made))
    assert made == []
    sweep(replace(options, measures=()), tmp_path / "out", pool=counting(made))
    assert made == [4]
