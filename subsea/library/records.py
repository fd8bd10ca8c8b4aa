"""Records of simulations: make, open and measure them; the names that a scenario may have."""

import math
from os import PathLike
from pathlib import Path
from typing import Any

from subsea.fish.species import species_names
from subsea.library.world import Changes, change_texts
from subsea.scenario.load import scenario_names
from subsea.study.record import Record, read_record
from subsea.study.report import measure as measures_of
from subsea.study.simulate import simulate as record_run
from subsea.world.world import TICK_S

PathText = str | PathLike[str]


def scenarios() -> list[str]:
    """Names of all scenarios: the shipped ones, then the user's own.

    >>> "peaceful" in subsea.scenarios()
    True
    """
    return scenario_names()


def species() -> list[str]:
    """Names of all species: the shipped ones, then the user's own.

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

    Returns:
        The path of the record.

    Raises:
        UserError: A faulty scenario, or a file that cannot be written.
        ValueError: A length under one tick.

    Ctrl-C keeps the ticks so far, and continues as KeyboardInterrupt.
    """
    if not TICK_S <= seconds < math.inf:
        raise ValueError(f"seconds: {seconds!r}, expected at least {TICK_S}")
    ticks = round(seconds / TICK_S)
    texts = change_texts(changes)
    record_run(ticks, Path(out), scenario, fish, seed, texts, force, tell=lambda line: None)
    return Path(out)


def open_record(path: PathText) -> Record:
    """Read a record of `subsea simulate` as arrays.

    Raises:
        UserError: A file that is missing, damaged, or no record.

    >>> path = subsea.simulate("peaceful", "run.h5", seconds=0.33, seed=1, fish=10)
    >>> subsea.open_record(path).position.shape  # ticks, fishes, axes
    (10, 10, 3)
    """
    return read_record(Path(path))


def measure(record: Record | PathText) -> dict[str, Any]:
    """All measures of a record, as `subsea study --json` writes them.

    docs/reference/records.md defines each of them.

    >>> path = subsea.simulate("peaceful", "run.h5", seconds=0.33, seed=1, fish=10)
    >>> subsea.measure(path)["fishes"]
    10
    """
    return measures_of(record if isinstance(record, Record) else open_record(record))
