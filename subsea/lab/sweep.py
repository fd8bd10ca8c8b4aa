"""`subsea sweep`: run every combination of seeds and values; collect the measures in a table.

Tables are Parquet and CSV files: equal rows give equal bytes.
"""

import csv
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import msgspec

from subsea.base.errors import UserError
from subsea.base.file_kinds import check_result, csv_file, signed
from subsea.base.files import check_folder, partial_folder, read_input, remove_abandoned, replacing
from subsea.base.progress import count_noun, progress, say
from subsea.base.system import require
from subsea.base.toml_edit import toml_value
from subsea.jobs.workers import MAX_ATTEMPTS, Check, Pool, serial
from subsea.lab.comparison import Row, flat_measures
from subsea.lab.own_measures import OwnMeasure
from subsea.lab.recording import Provenance, inputs_of
from subsea.lab.report import measure
from subsea.lab.run_store import RunStore
from subsea.lab.simulate import Run, record_run
from subsea.media.record import read_record
from subsea.scenario.load import load_scenario

PARQUET = signed("a Parquet table", b"PAR1")
CSV = csv_file("a table of `subsea sweep`", "run", "seed")

Line = dict[str, Any]  # a run: texts of TOML values before the column `ticks`, numbers after it


def columns_of(lines: Sequence[Line]) -> dict[str, list[Any]]:
    """Arrange lines as columns in the order of first appearance; None for missing numbers.

    A swept key is a column of numbers, or of true and false, if all its values are; else of texts.
    """
    names = dict.fromkeys(name for line in lines for name in line)
    columns = {name: [line.get(name) for line in lines] for name in names}
    return {name: _converted(values) for name, values in columns.items()}


def _converted(texts: list[Any]) -> list[Any]:
    if not all(isinstance(text, str) for text in texts):
        return texts
    values: list[Any] = []
    for text in texts:
        with suppress(ValueError, RecursionError):
            values.append(tomllib.loads(f"value = {text}")["value"])
    kinds = {type(value) for value in values}
    if len(values) < len(texts) or not (kinds <= {int, float} or kinds in ({bool}, {str})):
        return texts
    if float in kinds or (int in kinds and max(map(abs, values)) >= 2**63):
        return [float(value) for value in values]
    return values


def write_parquet(path: Path, lines: Sequence[Line]) -> None:
    """Write a table as a Parquet file."""
    import pyarrow
    from pyarrow import parquet

    columns = columns_of(lines)
    measures = [*columns][[*columns].index("ticks") + 1 :] if columns else []
    arrays = {
        name: pyarrow.array(values, pyarrow.float64() if name in measures else None)
        for name, values in columns.items()
    }
    with replacing(path) as temporary:
        parquet.write_table(pyarrow.table(arrays), temporary)


def write_csv(path: Path, lines: Sequence[Line]) -> None:
    """Write a table as a CSV file."""
    columns = columns_of(lines)
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))


MAX_RUNS = 100_000
_SEEDS = re.compile(r"(\d+)(?:[:-](\d+))?")
_CLOSING = {"[": "]", "{": "}"}


def read_seeds(text: str) -> tuple[int, ...]:
    """Read seeds such as ``1:64``, ``1-64`` or ``1,5,9``; a UserError for anything else."""
    seeds: list[int] = []
    for part in text.split(","):
        found = _SEEDS.fullmatch(part.strip())
        first = int(found[1]) if found and len(part) < 30 else -1
        last = int(found[2] or first) if found and first >= 0 else -1
        if not 0 <= first <= last < 2**32 or last - first >= MAX_RUNS:
            raise UserError(
                f"--seeds {text}: expected seeds such as 1:64 or 1,5,9, from 0 to 4294967295"
            )
        seeds += range(first, last + 1)
    if len(set(seeds)) < len(seeds):
        raise UserError(f"--seeds {text}: a seed is there twice")
    return tuple(seeds)


def read_values(settings: list[str]) -> dict[str, tuple[str, ...]]:
    """Read the values of each key of settings such as ``fish.0.number=10,20``.

    Commas within brackets, braces and quotes belong to a value.
    """
    found: dict[str, tuple[str, ...]] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        key = ".".join(step.strip() for step in key.split("."))
        values = split_values(text)
        if not equals or not key or not all(values):
            raise UserError(
                "expected KEY=VALUE,VALUE… such as fish.0.number=10,20", file=f"--set {setting}"
            )
        if key in found:
            raise UserError("is given twice; give all values at once", file=f"--set {key}")
        if len(set(values)) < len(values):
            raise UserError("a value is there twice", file=f"--set {setting}")
        if key == "seed":
            raise UserError("give the seeds with --seeds", file=f"--set {setting}")
        found[key] = values
    return found


def split_values(text: str) -> tuple[str, ...]:
    """Split a text at commas outside brackets, braces and quotes."""
    parts, part, closing, quote = [], "", "", ""
    escaped = False
    for letter in text:
        if quote:
            if letter == quote and not escaped:
                quote = ""
            escaped = letter == "\\" and quote == '"' and not escaped
        elif letter in "\"'":
            quote = letter
        elif letter in _CLOSING:
            closing += _CLOSING[letter]
        elif closing and letter == closing[-1]:
            closing = closing[:-1]
        elif letter == "," and not closing:
            parts.append(part.strip())
            part = ""
            continue
        part += letter
    return *parts, part.strip()


TABLE, TABLE_CSV = "sweep.parquet", "sweep.csv"
MAX_NAMED = 5  # runs that an error names


@dataclass(frozen=True)
class Sweep:
    """The runs of a sweep: every combination of `seeds`, `points` and `values` of each key.

    A point has one value for each of its keys, which are those of all points. Values are texts as
    in ``--set KEY=VALUE``, or what TOML can write.
    """

    scenario: str
    seeds: Sequence[int]
    ticks: int
    fish: int | None = None
    values: Mapping[str, Sequence[Any]] = field(default_factory=dict)
    points: Sequence[Mapping[str, Any]] = ()
    measures: tuple[OwnMeasure, ...] = ()
    rules: Mapping[str, Any] = field(default_factory=dict)  # `behaviors` and so on of each run

    @property
    def keys(self) -> list[str]:
        """The keys that differ between runs."""
        return [*self.values, *(self.points[0] if self.points else ())]

    def choices(self) -> Iterator[dict[str, str]]:
        """Give a text for each key, for every combination of points and values."""
        columns = {key: [_text(value) for value in values] for key, values in self.values.items()}
        points = [{key: _text(value) for key, value in one.items()} for one in self.points]
        for point in points or [{}]:
            for values in product(*columns.values()):
                yield dict(zip(columns, values, strict=True)) | point

    def __len__(self) -> int:
        """Count the runs."""
        number = len(self.seeds) * max(len(self.points), 1)
        for values in self.values.values():
            number *= len(values)
        return number

    def check(self) -> None:
        """Raise a UserError for too many runs, or points whose keys differ."""
        if not 0 < len(self) <= MAX_RUNS:
            raise UserError(f"{len(self):,} runs, expected 1 to {MAX_RUNS:,}")
        for number, point in enumerate(self.points):
            if point.keys() != self.points[0].keys():
                keys = ", ".join(self.points[0])
                raise UserError(f"point {number} of the sweep: expected values for {keys}")
        twice = [key for key in self.values if self.points and key in self.points[0]]
        if twice:
            raise UserError(f"{twice[0]}: has values and points, expected one of the two")
        if "seed" in self.keys:
            raise UserError("seed: give the seeds of a sweep, not values for it")


def _text(value: Any) -> str:
    return value if isinstance(value, str) else toml_value(value)


class _Job(NamedTuple):
    """A run for a worker, which may be another computer."""

    run: Run
    name: str  # of the scenario's file
    content: bytes
    inputs: str  # digest of everything that the result depends on
    folder: str  # for a record, if it exists there
    keep: bool
    measures: tuple[OwnMeasure, ...] = ()


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
    options.check()
    tables = _check_tables(out, csv, force)
    jobs = dict(_jobs(options, out, records))
    store = RunStore(out / "runs", say)
    rows: dict[str, Row] = {}
    if not force:
        rows = store.read({name: job.inputs for name, job in jobs.items()})
        rows = {name: row for name, row in rows.items() if _has_record(out, name, jobs[name])}
    missing = {name: job for name, job in jobs.items() if name not in rows}
    crashed: list[str] = []
    try:
        if missing:
            out.mkdir(parents=True, exist_ok=True)
            for folder in (out, out / "runs", out / "records"):
                remove_abandoned(folder)
            with store.writing(), partial_folder(out / "records") as scratch:
                given = {name: job._replace(folder=str(scratch)) for name, job in missing.items()}
                with progress(len(jobs), "run", len(rows)) as count:
                    for name, result in pool(make_run, given, check):
                        if result is None:
                            crashed.append(name)
                            continue
                        row, record = result
                        if record is not None:
                            _keep(out, name, record)
                        store.add(name, jobs[name].inputs, row)
                        rows[name] = row
                        count()
    except KeyboardInterrupt:
        kept = count_noun(len(rows), "run", "runs")
        raise KeyboardInterrupt(f"{out}: {kept} kept; run the same command to continue") from None
    lines = [
        _line(name, jobs[name].run, options.keys) | rows[name] for name in jobs if name in rows
    ]
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
    """List the tables to write and their writers; a UserError if one cannot be written."""
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
    """List all runs with their names, in the order of the table; check every combination."""
    for choice in options.choices():
        changes = tuple(f"{key}={value}" for key, value in choice.items())
        run = Run(options.scenario, options.ticks, None, options.fish, changes, **options.rules)
        chosen, source, _ = load_scenario(options.scenario, changes)
        if not any(shoal.number for shoal in chosen.fish):
            raise UserError("has no fishes, nothing to record", file=source)
        origin = inputs_of(chosen, source, changes, __file__)
        content = read_input(source)
        for seed in options.seeds:
            one = replace(run, seed=seed)
            inputs = _digest(one, origin, options.measures)
            yield (
                inputs[:16],
                _Job(one, source.name, content, inputs, "", records, options.measures),
            )


def _digest(run: Run, origin: Provenance, measures: Sequence[OwnMeasure]) -> str:
    """Hash everything that the result of a run depends on."""
    own = [one.description for one in measures]
    inputs = [run.ticks, run.seed, run.fish, origin, *run.rules, *own]
    return sha256(msgspec.json.encode(inputs)).hexdigest()


def make_run(job: _Job) -> tuple[Row, bytes | None]:
    """Make a run on any computer; returns its measures and, if wanted, its record."""
    place = Path(job.folder)
    with TemporaryDirectory(dir=place if place.is_dir() else None) as folder:
        scenario, out = Path(folder) / job.name, Path(folder) / "run.h5"
        scenario.write_bytes(job.content)
        run = replace(job.run, scenario=str(scenario))
        loaded = load_scenario(run.scenario, run.changes)
        if _digest(run, inputs_of(*loaded, __file__), job.measures) != job.inputs:
            raise UserError(
                "a worker has another version of subsea, numpy, numba or the species; install the "
                "same"
            )
        try:
            record_run(run, out)
            row = flat_measures(measure(read_record(out), own=job.measures))
        except UserError as fault:
            raise type(fault)(f"{_describe(run)}: {fault}") from fault
        return row, out.read_bytes() if job.keep else None


def _describe(run: Run) -> str:
    return " ".join([f"seed {run.seed}", *run.changes])


def _keep(out: Path, name: str, record: bytes) -> None:
    """Write the record of a finished run."""
    with replacing(out / "records" / f"{name}.h5") as temporary:
        temporary.write_bytes(record)


def _has_record(out: Path, name: str, job: _Job) -> bool:
    """True unless the record of a run is wanted and missing."""
    return not job.keep or (out / "records" / f"{name}.h5").is_file()


def _line(name: str, run: Run, keys: Iterable[str]) -> dict[str, Any]:
    """Fill the first columns of a run."""
    values = [change.partition("=")[2] for change in run.changes]
    return {
        "run": name,
        "seed": run.seed,
        **dict(zip(keys, values, strict=True)),
        "ticks": run.ticks,
    }
