"""`subsea study --validate`: how fishes swim, school and hunt in seas, beside measured fishes."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.progress import progress
from subsea.base.system import is_path
from subsea.dive.start import start_world
from subsea.fish.species import load_species, shipped_species
from subsea.jobs.workers import Check, Pool
from subsea.lab import measures as predation
from subsea.lab import schooling, swimming
from subsea.lab.measures import Outside, Predation, outside
from subsea.lab.schooling import Schooling
from subsea.lab.simulate import live_records
from subsea.lab.swimming import Swimming
from subsea.motor.playback import TEMPO
from subsea.repertoire import SEGMENTS
from subsea.scenario.load import load_scenario, scenario_names
from subsea.world.world import World

CROWD = {"open-ocean": 3000}  # fishes of a scenario that has more
SCHOOL, SCHOOL_SIZES = "schooling", (10, 64, 144)
HUNT, GROUP_SIZES = "preying", (1, 6, 20)
BLOCK_FISH_TICKS = 3_000_000  # measured at once: about 300 MB
MOST_SAMPLES = 5000  # kept of one run, species and quantity


class SeaTrial(NamedTuple):
    """One run to measure."""

    label: str
    scenario: str
    seed: int
    ticks: int
    fish: int | None = None
    changes: tuple[str, ...] = ()
    size: int = 0  # of the school or of the group of prey, for those trials
    hunt: bool = False


class SeaMeasures(NamedTuple):
    """The measures of one run."""

    swims: dict[str, Swimming]  # by name of the species' file
    schools: list[Schooling]
    outside: list[Outside]
    predation: Predation


@dataclass(frozen=True)
class Validation:
    """The runs of a validation."""

    scenarios: Sequence[str]
    seeds: Sequence[int]
    ticks: int


def default_scenarios() -> list[str]:
    """The shipped scenarios with fishes."""
    return [name for name in scenario_names() if any(s.number for s in load_scenario(name)[0].fish)]


def trials(options: Validation) -> Iterator[SeaTrial]:
    """All runs: the scenarios, schools of several sizes, and groups of prey with one predator.

    The last two only if their scenarios are among those that are given. UserError for a scenario
    that cannot be read.
    """
    for name in options.scenarios:
        chosen = load_scenario(name).scenario
        number = sum(shoal.number for shoal in chosen.fish)
        most = CROWD.get(name, number)
        fish = most if most < number else None
        label = Path(name).stem if is_path(name, ".toml") else name
        label = f"{label} of {fish} fishes" if fish else label
        for seed in options.seeds:
            yield SeaTrial(label, name, seed, options.ticks, fish)
    for seed in options.seeds:
        if SCHOOL in options.scenarios:
            for size in SCHOOL_SIZES:
                yield SeaTrial(f"{SCHOOL} of {size}", SCHOOL, seed, options.ticks, size, size=size)
        if HUNT in options.scenarios:
            for size in GROUP_SIZES:
                yield SeaTrial(f"{HUNT} on {size}", HUNT, seed, options.ticks, None,
                               one_group(HUNT, size), size, hunt=True)  # fmt: skip


def one_group(scenario: str, size: int) -> tuple[str, ...]:
    """Changes to a scenario that leave its predators and one shoal of `size` prey."""
    changes, found = [], False
    for k, shoal in enumerate(load_scenario(scenario)[0].fish):
        kind = shoal.kind or load_species(shoal.species).kind
        number = shoal.number if kind == "predator" else 0
        if kind == "prey" and not found:
            number, found = size, True
        changes.append(f"fish.{k}.number={number}")
    return tuple(changes)


def run_sea(trial: SeaTrial) -> SeaMeasures:
    """Run and measure one trial, on any process."""
    world = start_world(
        trial.scenario, trial.seed, trial.fish, lambda message: None, changes=trial.changes
    )
    slowest = slowest_strokes(world)
    keys = {load_species(name).name: name for name in shipped_species()}
    swims: dict[str, list[Swimming]] = {}
    schools: list[Schooling] = []
    beyond: list[Outside] = []
    hunts: list[Predation] = []
    for record in live_records(world, trial.ticks, BLOCK_FISH_TICKS):
        for name, found in swimming.swimming(record, slowest).items():
            swims.setdefault(keys.get(name, name), []).append(found)
        schools += schooling.schooling(record)
        beyond += outside(record)
        hunts.append(predation.predation(record))
    thinned = {name: _thinned(swimming.joined(parts)) for name, parts in swims.items()}
    return SeaMeasures(thinned, schooling.joined(schools), beyond, predation.joined(hunts))


def slowest_strokes(world: World) -> Array:
    """Speed (n,) of the slowest stroke of each fish, body lengths a second."""
    fishes, library = world.state.fishes, world.library
    recorded = library.speed[fishes.species, SEGMENTS.index("swim_slow")]
    return np.asarray(TEMPO[0] * recorded * fishes.scale * fishes.rate / fishes.length, np.float64)


def _thinned(found: Swimming) -> Swimming:
    parts: dict[str, Any] = {
        name: value[:: len(value) // MOST_SAMPLES + 1]
        for name, value in found._asdict().items()
        if isinstance(value, np.ndarray)
    }
    return found._replace(**parts)


def run_trials(
    chosen: Iterable[SeaTrial],
    pool: Pool[int],
    check: Check = lambda: None,
    work: Callable[[SeaTrial], SeaMeasures] = run_sea,
) -> tuple[list[tuple[SeaTrial, SeaMeasures]], list[SeaTrial]]:
    """Run trials; returns them with their measures in their order, and those that crashed.

    `check` is called meanwhile and may raise.
    """
    jobs = dict(enumerate(chosen))
    done: dict[int, SeaMeasures] = {}
    crashed = []
    with progress(len(jobs), "run") as count:
        for k, result in pool(work, jobs, check):
            if result is None:
                crashed.append(jobs[k])
            else:
                done[k] = result
            count()
    return [(jobs[k], done[k]) for k in sorted(done)], crashed
