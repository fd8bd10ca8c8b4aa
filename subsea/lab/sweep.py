"""`subsea sweep`: run every combination of seeds and values; collect the measures in a table."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import msgspec

from subsea.base.atomic_io import check_folder, replacing
from subsea.base.console import count_noun
from subsea.base.errors import UserError
from subsea.base.extras import require
from subsea.base.file_kinds import check_result
from subsea.base.input_files import read_input
from subsea.base.progress import progress
from subsea.base.toml_edit import toml_value
from subsea.jobs.workers import MAX_ATTEMPTS, Check, Pool, serial
from subsea.lab.flat_measures import Row, flat_measures
from subsea.lab.provenance import Provenance, provenance_of
from subsea.lab.report import measure
from subsea.lab.simulate import Run, record_run
from subsea.lab.sweep_table import CSV, PARQUET, write_csv, write_parquet
from subsea.lab.sweep_values import MAX_RUNS
from subsea.media.record import read_record
from subsea.scenario.load import load_scenario

TABLE, TABLE_CSV = "sweep.parquet", "sweep.csv"
MAX_NAMED = 5  # runs that an error names


@dataclass(frozen=True)
class Sweep:
    """The runs of a sweep: every combination of `seeds` and of the `values` of each key.

    Values are texts as in ``--set KEY=VALUE``, or what TOML can write.
    """

    scenario: str
    seeds: Sequence[int]
    ticks: int
    fish: int | None = None
    values: Mapping[str, Sequence[Any]] = field(default_factory=dict)


class _Job(NamedTuple):
    """A run for a worker, which may be another computer."""

    run: Run
    name: str  # of the scenario's file
    content: bytes
    inputs: str  # digest of everything that the result depends on
    folder: str  # for a record, if it exists there
    keep: bool


class _Result(msgspec.Struct):
    inputs: str
    measures: Row


def sweep(
    options: Sweep,
    out: Path,
    *,
    pool: Pool[str] = serial,
    csv: bool = False,
    records: bool = False,
    force: bool = False,
    check: Check = lambda: None,
) -> Path:
    """Run a sweep and write its table to the folder `out`; returns the path of the table.

    The table is ``sweep.parquet``, or ``sweep.csv`` without PyArrow if `csv` is set. With `records`
    the record of each run stays in ``out/records``. Runs that `out` has already are not made again,
    except with `force`. `check` is called meanwhile and may raise; finished runs stay. Raises a
    UserError for invalid values before the first run, and at the end if runs crashed.
    """
    tables = _check_tables(out, csv, force)
    jobs = dict(_jobs(options, out, records))
    rows: dict[str, Row] = {}
    if not force:
        rows = {name: row for name, job in jobs.items() if (row := _finished(out, name, job))}
    missing = {name: job for name, job in jobs.items() if name not in rows}
    crashed: list[str] = []
    try:
        if missing:
            out.mkdir(parents=True, exist_ok=True)
            with TemporaryDirectory(dir=out, prefix=".records-") as folder:
                given = {name: job._replace(folder=folder) for name, job in missing.items()}
                with progress(len(jobs), "run", len(rows)) as count:
                    for name, result in pool(make_run, given, check):
                        if result is None:
                            crashed.append(name)
                            continue
                        rows[name] = _save(out, name, jobs[name], *result)
                        count()
    except KeyboardInterrupt:
        kept = count_noun(len(rows), "run", "runs")
        raise KeyboardInterrupt(f"{out}: {kept} kept; run the same command to continue") from None
    keys = [*options.values]
    lines = [_line(name, jobs[name].run, keys) | rows[name] for name in jobs if name in rows]
    for path, write in tables.items():
        write(path, lines)
    if crashed:
        named = "; ".join(_describe(jobs[name].run) for name in crashed[:MAX_NAMED])
        more = f" and {len(crashed) - MAX_NAMED} more" if len(crashed) > MAX_NAMED else ""
        raise UserError(
            f"without {count_noun(len(crashed), 'run', 'runs')} whose process crashed "
            f"{MAX_ATTEMPTS} times ({named}{more}); is there enough memory?",
            file=next(iter(tables)),
        )
    return next(iter(tables))


def _check_tables(out: Path, csv: bool, force: bool) -> dict[Path, Callable[..., None]]:
    """The tables to write and their writers; a UserError if one cannot be written."""
    check_folder(out)
    tables: dict[Path, Callable[..., None]] = {}
    try:
        require("sweep", "a table in Parquet (without it: --csv)")
        tables[out / TABLE] = write_parquet
        check_result(out / TABLE, PARQUET, force)
    except UserError:
        if not csv or tables:
            raise
    if csv:
        tables[out / TABLE_CSV] = write_csv
        check_result(out / TABLE_CSV, CSV, force)
    return tables


def _jobs(options: Sweep, out: Path, records: bool) -> Iterator[tuple[str, _Job]]:
    """All runs with their names, in the order of the table; checks every combination."""
    texts = {
        key: [value if isinstance(value, str) else toml_value(value) for value in values]
        for key, values in options.values.items()
    }
    number = len(options.seeds)
    for choices in texts.values():
        number *= len(choices)
    if not 0 < number <= MAX_RUNS:
        raise UserError(f"{number:,} runs, expected 1 to {MAX_RUNS:,}")
    for values in product(*texts.values()):
        changes = tuple(f"{key}={value}" for key, value in zip(texts, values, strict=True))
        run = Run(options.scenario, options.ticks, None, options.fish, changes)
        chosen, source = load_scenario(options.scenario, changes)
        if not any(shoal.number for shoal in chosen.fish):
            raise UserError("has no fishes, nothing to record", file=source)
        origin = provenance_of(chosen, source, changes, __file__)
        content = read_input(source)
        for seed in options.seeds:
            one = replace(run, seed=seed)
            inputs = _digest(one, origin)
            yield inputs[:16], _Job(one, source.name, content, inputs, "", records)


def _digest(run: Run, origin: Provenance) -> str:
    """A hash of everything that the result of a run depends on."""
    inputs = [run.ticks, run.seed, run.fish, origin]
    return sha256(msgspec.json.encode(inputs)).hexdigest()


def make_run(job: _Job) -> tuple[Row, bytes | None]:
    """Make a run on any computer; returns its measures and, if wanted, its record."""
    place = Path(job.folder)
    with TemporaryDirectory(dir=place if place.is_dir() else None) as folder:
        scenario, out = Path(folder) / job.name, Path(folder) / "run.h5"
        scenario.write_bytes(job.content)
        run = replace(job.run, scenario=str(scenario))
        chosen, source = load_scenario(run.scenario, run.changes)
        if _digest(run, provenance_of(chosen, source, run.changes, __file__)) != job.inputs:
            raise UserError(
                "a worker has another version of subsea, numpy, numba or the species; install the "
                "same"
            )
        try:
            record_run(run, out)
            row = flat_measures(measure(read_record(out)))
        except UserError as fault:
            raise UserError(f"{_describe(run)}: {fault}") from fault
        return row, out.read_bytes() if job.keep else None


def _describe(run: Run) -> str:
    return " ".join([f"seed {run.seed}", *run.changes])


def _result_path(out: Path, name: str) -> Path:
    return out / "runs" / f"{name}.json"


def _record_path(out: Path, name: str) -> Path:
    return out / "records" / f"{name}.h5"


def _save(out: Path, name: str, job: _Job, row: Row, record: bytes | None) -> Row:
    """Write the result of a finished run, and its record before it."""
    if record is not None:
        with replacing(_record_path(out, name)) as temporary:
            temporary.write_bytes(record)
    with replacing(_result_path(out, name)) as temporary:
        temporary.write_text(json.dumps({"inputs": job.inputs, "measures": row}, indent=1))
    return row


def _finished(out: Path, name: str, job: _Job) -> Row | None:
    """The measures of a run that `out` has already; None if it must be made."""
    if job.keep and not _record_path(out, name).is_file():
        return None
    return read_result(_result_path(out, name), job.inputs)


def read_result(path: Path, inputs: str) -> Row | None:
    """The measures in a file of a run with these inputs; None if missing, damaged or of others."""
    try:
        found = msgspec.json.decode(read_input(path), type=_Result)
    except (UserError, msgspec.MsgspecError, ValueError, RecursionError):
        return None
    return found.measures if found.inputs == inputs else None


def _line(name: str, run: Run, keys: Iterable[str]) -> dict[str, Any]:
    """The first columns of a run."""
    values = [change.partition("=")[2] for change in run.changes]
    return {
        "run": name,
        "seed": run.seed,
        **dict(zip(keys, values, strict=True)),
        "ticks": run.ticks,
    }
