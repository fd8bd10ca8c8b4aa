"""Records of simulations: make, open and measure them; the names that a scenario may have."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any, Unpack, cast

from subsea.base.errors import UserError
from subsea.base.interrupts import deferred_interrupts
from subsea.base.progress import say
from subsea.base.system import cores, missing_packages
from subsea.dive.warm_up import warm_up
from subsea.fish.species import species_names
from subsea.jobs.dask_cluster import dask_pool
from subsea.jobs.workers import process_pool, serial
from subsea.lab.functions import stays
from subsea.lab.own_measures import own_measures
from subsea.lab.report import measure as measures_of
from subsea.lab.rules import Rules, RulesGiven
from subsea.lab.simulate import Run, record_world, simulate_run
from subsea.lab.sweep import Sweep
from subsea.lab.sweep import sweep as run_sweep
from subsea.library import Changes, World, change_texts, check_numbers
from subsea.media.record import Record, read_record
from subsea.scenario.load import scenario_names
from subsea.world.world import TICK_S

PathText = str | PathLike[str]
Values = Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]]


class SweepGiven(RulesGiven, total=False):
    """More keywords of `sweep`."""

    measures: Sequence[Callable[..., Any]]
    cluster: Any


def scenarios() -> list[str]:
    """List the names of all scenarios: the shipped ones, then the user's own.

    Examples:
        >>> "peaceful" in subsea.scenarios()
        True
    """
    return scenario_names()


def species() -> list[str]:
    """List the names of all species: the shipped ones, then the user's own.

    Examples:
        >>> "fusilier" in subsea.species()
        True
    """
    return species_names()


def simulate(
    scenario: str,
    out: PathText,
    *,
    seconds: float,
    seed: int | None = None,
    fish: int | None = None,
    changes: Changes = (),
    force: bool = False,
    **rules: Unpack[RulesGiven],
) -> Path:
    """Record a run of a scenario, as `subsea simulate` does.

    Args:
        scenario: A name of `subsea.scenarios()`, or the path of a file.
        out: The record to write; its name ends in ``.h5`` or ``.hdf5``.
        seconds: Length of the run, rounded to ticks of 0.033 s.
        seed: The seed of all random numbers; None: the scenario's.
        fish: The number of fishes to which its shoals are scaled; None: the scenario's.
        changes: Values that replace the scenario's; see `subsea.load`.
        force: True replaces a file that is not a record, too.
        **rules: `behaviors` and `senses` as of `subsea.load`. `orders` is a function that is called
            before each tick with the `subsea.World`, and returns an order as of `World.step`, or
            None.

    Returns:
        The path of the record.

    Raises:
        UserError: A faulty scenario, a file that cannot be written, or a rule that fails: the
            record keeps the ticks so far.
        ValueError: A length under one tick, or a seed or number of fishes outside its range.

    Ctrl-C keeps the ticks so far, and continues as KeyboardInterrupt.

    Examples:
        >>> ahead = lambda world: subsea.Helm(surge=0.5)
        >>> path = subsea.simulate("peaceful", "run.h5", seconds=0.33, fish=5, orders=ahead)
    """
    check_numbers(seed, fish)
    given = Rules(**rules)
    texts = tuple(change_texts(changes))
    run = Run(scenario, _ticks(seconds), seed, fish, texts, **given.fields)
    simulate_run(run, Path(out), force, tell=lambda line: None)
    return Path(out)


@contextmanager
def record(world: World, out: PathText, *, force: bool = False) -> Iterator[Path]:
    """Record every tick that a world makes inside a ``with`` block.

    The ticks may come from a loop, a pilot, an environment or a rule.

    Args:
        world: A world of `subsea.load`, or that of an environment: ``env.unwrapped.world``.
        out: The record to write; its name ends in ``.h5`` or ``.hdf5``.
        force: True replaces a file that is not a record, too.

    Yields:
        The path of the record, which is there after the block. It has the same datasets as that of
        `subsea.simulate`; its attribute `moved_by` tells what moved the fishes and the submarine.

    Raises:
        UserError: A file that cannot be written, no tick in the block, or a world that does not go
            on by single ticks, as after `World.restore` or the reset of an environment.

    Ctrl-C and other exceptions in the block keep the ticks so far, and continue.

    Examples:
        >>> world = subsea.load("peaceful", seed=1, fish=10)
        >>> with subsea.record(world, "mine.h5") as path:
        ...     for _ in range(10):
        ...         world.step(1, subsea.TeleopCommand(fish=3, turn=0.5, speed=0.8))
        >>> subsea.measure(path)["ticks"]
        10
    """
    if not isinstance(world, World) or world.loaded is None:
        raise TypeError(f"record: expected a world of subsea.load, got {world!r}")
    with record_world(world.internal, world.loaded, Path(out), force):
        yield Path(out)


def sweep(
    scenario: str,
    out: PathText,
    *,
    seeds: Iterable[int],
    seconds: float,
    values: Values | None = None,
    fish: int | None = None,
    jobs: int | None = None,
    records: bool = False,
    **more: Unpack[SweepGiven],
) -> Path:
    """Record and measure every combination of seeds and values, as `subsea sweep` does.

    Args:
        scenario: A name of `subsea.scenarios()`, or the path of a file.
        out: A folder for the results. Runs that it has already are not made again.
        seeds: The seeds.
        seconds: Length of each run, rounded to ticks of 0.033 s.
        values: The values of each key: `{"nature.timidity": [1.0, 2.0]}`. All combinations run.
            Or a list of points, each with a value of each key, as of `subsea.latin_hypercube` and
            `subsea.sobol`.
        fish: The number of fishes to which shoals are scaled; None: the scenario's.
        jobs: Parallel processes; None: one for each core; 1: none but this one. A script that uses
            several must call this below ``if __name__ == "__main__":``, as Python asks.
        records: True keeps the record of each run in the folder ``records``.
        **more: `measures` are more measures, as of `subsea.measure`. `cluster` is a Dask cluster or
            client, or the address of a scheduler, whose workers run in place of processes here.
            `behaviors`, `senses` and `orders` are as of `subsea.simulate`. Other processes import
            all functions from their modules. Those of a notebook or script run in this process.

    Returns:
        The table with a row for each run: Parquet, or CSV without the extra `sweep`.
        docs/reference/records.md describes its columns.

    Raises:
        UserError: A faulty scenario or value, a file that cannot be written, a rule or measure that
            fails, or several `jobs` or a cluster with functions that other processes cannot import.
        ValueError: A length under one tick, less than one job, or a seed or number of fishes
            outside its range.

    Examples:
        >>> table = subsea.sweep("peaceful", "few", seeds=[1, 2], seconds=0.33, fish=10, jobs=1)
        >>> table.name
        'sweep.parquet'
    """
    if jobs is not None and jobs < 1:
        raise ValueError(f"jobs: {jobs!r}, expected at least 1")
    cluster = more.get("cluster")
    if cluster is not None and jobs is not None:
        raise ValueError("jobs and cluster: give one of the two")
    measures = own_measures(more.get("measures", ()))
    rules = {name: value for name, value in more.items() if name in RulesGiven.__annotations__}
    unknown_names = more.keys() - SweepGiven.__annotations__.keys()
    if unknown_names:
        raise TypeError(f"sweep: unexpected keyword {min(unknown_names)!r}")
    seeds, given = [*seeds], Rules(**cast(RulesGiven, rules))
    for seed in seeds:
        check_numbers(seed, fish)
    alone = given.stay or stays(measures)
    if alone and (cluster is not None or (jobs is not None and jobs > 1)):
        raise UserError(
            "sweep: other processes cannot import these rules or measures; put them into a module "
            "that is installed or in PYTHONPATH, or give jobs=1"
        )
    table, points = (values, ()) if isinstance(values, Mapping) else ({}, values or ())
    runs = Sweep(
        scenario, seeds, _ticks(seconds), fish, table, tuple(points), measures, given.fields
    )
    jobs = (1 if alone else cores()) if jobs is None else jobs
    if cluster is not None:
        pool = dask_pool(cluster)
    else:
        pool = serial if jobs == 1 else process_pool(jobs)
        warm_up(say)
    with deferred_interrupts() as check:
        return run_sweep(
            runs,
            Path(out),
            pool=pool,
            csv=bool(missing_packages("sweep")),
            records=records,
            check=check,
        )


def open_record(path: PathText) -> Record:
    """Read a record of `subsea simulate` as arrays.

    Raises:
        UserError: A file that is missing, damaged, or no record.

    Examples:
        >>> path = subsea.simulate("peaceful", "run.h5", seconds=0.33, seed=1, fish=10)
        >>> subsea.open_record(path).position.shape  # ticks, fishes, axes
        (10, 10, 3)
    """
    return read_record(Path(path))


def measure(
    record: Record | PathText, measures: Iterable[Callable[..., Any]] = ()
) -> dict[str, Any]:
    """Compute all measures of a record, as `subsea study --json` writes them.

    docs/reference/records.md defines each of them.

    Args:
        record: A record, or its file.
        measures: Functions of your own. Their parameters are names of the arrays and numbers of
            `subsea.Record`, such as `position` or `tick_s`, or `record` for all of it; those with a
            default value are yours. A function returns a finite number, a table of numbers by name,
            or None where there is nothing to measure.

    Returns:
        The measures by name; those of your own in `own`, by the names of their functions.

    Raises:
        UserError: A file that cannot be read; an unknown parameter; a function that raises, or that
            returns anything else.

    Examples:
        >>> def deepest_cm(position):
        ...     return -position[..., 2].min()
        >>> path = subsea.simulate("peaceful", "run.h5", seconds=0.33, seed=1, fish=10)
        >>> found = subsea.measure(path, [deepest_cm])
        >>> found["fishes"], 0 < found["own"]["deepest_cm"] < 800
        (10, True)
    """
    own = own_measures(measures)
    read = record if isinstance(record, Record) else open_record(record)
    return measures_of(read, own=own)


def _ticks(seconds: float) -> int:
    """Convert seconds to ticks; a ValueError for less than one."""
    if not TICK_S <= seconds < math.inf:
        raise ValueError(f"seconds: {seconds!r}, expected at least {TICK_S}")
    return round(seconds / TICK_S)
