"""`subsea simulate`: record every fish, for studies. No OpenGL."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from subsea.base import interrupts
from subsea.base.errors import UserError
from subsea.base.file_kinds import check_result
from subsea.base.progress import say
from subsea.behavior.intention import Behavior, Routine
from subsea.dive.start import WAKING, Say
from subsea.dive.warm_up import warm_up
from subsea.lab.functions import described
from subsea.lab.recording import (
    Laps,
    check_changes,
    constants_of,
    empty_block,
    extent,
    names_of,
    note,
    provenance_of,
    recorded,
    recorder_of,
)
from subsea.media import record
from subsea.scenario.load import LoadedScenario, load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import Order, step
from subsea.world.world import TICK_S, World

SUFFIXES = (".h5", ".hdf5")


@dataclass(frozen=True)
class Run:
    """The inputs of a simulation; None: as in the scenario."""

    scenario: str  # name or path
    ticks: int
    seed: int | None = None
    fish: int | None = None
    changes: tuple[str, ...] = ()  # made to the scenario before its text is stored
    behaviors: tuple[Behavior, ...] = ()  # which replace those of their names, or are more
    senses: tuple[Routine, ...] = ()
    orders: Callable[[World], Order] | None = None  # called before each tick; None: nobody steers

    @property
    def rules(self) -> tuple[str, ...]:
        """Describe the code that comes with the run, whose changes change its result."""
        parts = *(one.routine for one in self.behaviors), *self.senses, self.orders
        desires = (one for behavior in self.behaviors for _, one in behavior.desires)
        return tuple(described(one) for one in (*parts, *desires) if one is not None)


def simulate(
    ticks: int, out: Path, scenario: str, fish: int | None, seed: int | None,
    changes: Sequence[str] = (), force: bool = False, tell: Callable[[str], None] = say,
) -> str:  # fmt: skip
    """Record `ticks` ticks of a world, as `simulate_run` does, without rules."""
    return simulate_run(Run(scenario, ticks, seed, fish, tuple(changes)), out, force, tell)


def simulate_run(run: Run, out: Path, force: bool = False, tell: Say = say) -> str:
    """Record a run into `out`; returns the extent of the record in words.

    Ctrl-C leaves a valid file with the ticks so far. With `force` a file that is not a record is
    replaced, too. `tell` gets lines on the progress.
    """
    check_out(out, force)
    with interrupts.deferred_interrupts() as check:
        world = record_run(
            run, out, tell, lambda ticks: tqdm(ticks, unit="tick", disable=None), check
        )
    for line in world.notices:
        tell(line)
    return extent(run.ticks, len(world.state.fishes.species))


def check_out(out: Path, force: bool) -> None:
    """Raise a UserError unless `out` can be a record."""
    if out.suffix.lower() not in SUFFIXES:
        raise UserError(f"expected a name that ends in {' or '.join(SUFFIXES)}", file=out)
    check_result(out, record.RECORD, force)


def record_run(
    run: Run,
    out: Path,
    tell: Say = lambda message: None,
    progress: Callable[[Iterable[int]], Iterable[int]] = iter,
    check: Callable[[], None] = lambda: None,
) -> World:
    """Record a run into `out`; returns its world.

    `tell` gets messages; `progress` wraps the iterable of ticks. `check` is called before each
    tick: if it raises KeyboardInterrupt, the file has the ticks so far. So it has if a rule fails.
    """
    loaded = load_scenario(run.scenario, run.changes)
    check_changes(run.changes)
    if not any(shoal.number for shoal in loaded.scenario.fish):
        raise UserError("has no fishes, nothing to record", file=loaded.path)
    warm_up(tell)
    world = create_world(
        loaded.scenario, run.seed, run.fish, tell, source=str(loaded.path), behaviors=run.behaviors
    )
    world.senses = run.senses
    tell(WAKING)
    provenance = provenance_of(*loaded, __file__)
    fault: UserError | None = None
    with recorder_of(world, out, provenance, run.ticks) as recorder:
        if run.orders is not None:
            recorder.movers[f"orders: {described(run.orders)}"] = None
        try:
            for _ in progress(range(run.ticks)):
                check()
                step(world, NEUTRAL if run.orders is None else run.orders(world))
                recorder.note(world)
        except KeyboardInterrupt:
            if not recorder.ticks:
                raise
            raise KeyboardInterrupt(f"{out}: {recorder.extent} kept") from None
        except UserError as failed:
            if not recorder.ticks:
                raise
            fault = type(failed)(f"{failed}; {out}: {recorder.extent} kept")
    if fault is not None:
        raise fault
    return world


@contextmanager
def record_world(world: World, loaded: LoadedScenario, out: Path, force: bool) -> Iterator[None]:
    """Record into `out` every tick that a world of a scenario makes inside.

    See `recorded` for what an exception leaves.
    """
    check_out(out, force)
    check_changes(loaded.changes)
    if not len(world.state.fishes.species):
        raise UserError("has no fishes, nothing to record", file=loaded.path)
    with recorded(world, out, provenance_of(*loaded, __file__)):
        yield


def live_records(world: World, ticks: int, fish_ticks: int) -> Iterator[record.Record]:
    """Step a world for `ticks` ticks; yield records of at most `fish_ticks` each, in memory.

    `check`, which may raise, is called before each tick.
    """
    number = len(world.state.fishes.species)
    names = {name: list(words) for name, words in names_of(world).items()}
    constants = constants_of(world)
    done = 0
    while done < ticks:
        length = min(max(fish_ticks // number, 1), ticks - done)
        laps = Laps(world)
        block = empty_block(length, number)
        for row in range(length):
            if done + row:
                step(world, NEUTRAL)
            note(world, block, row, laps)
        done += length
        fields: dict[str, Any] = {
            name: (block | constants)[path] for name, path in record.READ.items()
        }
        fields |= {name: words for name, words in names.items() if name in record.Record._fields}
        yield record.Record(
            **fields,
            tick_s=TICK_S,
            seed=world.state.seed,
            radius_cm=world.scenario.bounds.radius_cm,
            half_width_cm=float(world.state.sea.half_width),
            alarmed=world.nature.alarmed,
            species_keys=tuple(world.scenario.species),
            period=world.state.fishes.period.astype(np.float64),
        )
