"""`subsea simulate`: record every fish, for studies. No OpenGL."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from subsea import __version__
from subsea.base import hdf5, interrupts
from subsea.base.errors import UserError
from subsea.base.file_kinds import check_result
from subsea.base.files import file_hash
from subsea.base.progress import count_noun, say
from subsea.base.source_stamp import source_stamp
from subsea.behavior.table import INTENTIONS
from subsea.dive.start import Say, ready_world
from subsea.fish.species import repertoire_file, species_file
from subsea.media import record
from subsea.motor.pose import centres_world, ends_world
from subsea.repertoire import SEGMENTS
from subsea.scenario.load import load_scenario
from subsea.scenario.save import scenario_text
from subsea.scenario.schema import Scenario
from subsea.state import COURTSHIP, KINDS, MENTAL_STATES
from subsea.submarine.vessel import NEUTRAL
from subsea.world.step import step
from subsea.world.world import TICK_S, World

SUFFIXES = (".h5", ".hdf5")
MAX_CHANGES = 15_000  # characters; an attribute holds 64 KB
BLOCK_FISH_TICKS = 200_000  # held in memory between two writes: about 16 MB

Rows = dict[str, NDArray[Any]]
Event = tuple[float, int, tuple[int, int]]  # time, direction, the fishes concerned
ROLES: dict[str, tuple[int, ...]] = {
    "direction/began": (),
    "direction/number": (),
    "direction/cast": (2,),
}

# Meaning of `minds.target` for each intention; others have no target.
TARGETS = {
    "avoid": "fish",
    "escape": "fish",
    "eat": "speck of plankton; of predators a fish",
    "mate": "fish",
}
_SCALES = {
    name: [record.DIMENSIONS[one][0] for one in field.dimensions]
    for name, field in (record.FIELDS | record.COORDINATES).items()
}
# Datasets whose values are indices, and the attribute with the names.
CODES = {
    "fish/intention": "intention_names",
    "fish/segment": "segment_names",
    "fish/courtship": "courtship_names",
    "fish/species": "species_names",
    "fish/kind": "kind_names",
}


@dataclass(frozen=True)
class Run:
    """The inputs of a simulation; None: as in the scenario."""

    scenario: str  # name or path
    ticks: int
    seed: int | None = None
    fish: int | None = None
    changes: tuple[str, ...] = ()  # made to the scenario before its text is stored


class Provenance(NamedTuple):
    """Versions and hashes of everything that a run is made from, except its seed and length."""

    program: str
    packages: str  # versions of packages that may change a result
    code_sha256: str
    scenario: str  # its text, with the changes
    scenario_sha256: str  # of its file, without them
    changes: tuple[str, ...]
    species_keys: tuple[str, ...]
    species_sha256: tuple[str, ...]  # of the file of each
    repertoire_sha256: tuple[str, ...]


def provenance_of(
    scenario: Scenario, source: Path, changes: Sequence[str], module: str
) -> Provenance:
    """Collect the provenance of a run of a scenario from the file `source`.

    `module` is the file of the code that makes the result. A missing file is a UserError.
    """
    names = tuple(scenario.species)
    return Provenance(
        program=f"subsea {__version__}",
        packages=f"numpy {np.__version__}, numba {numba.__version__}",
        code_sha256=source_stamp(Path(module).resolve()),
        scenario=scenario_text(scenario, source),
        scenario_sha256=file_hash(source),
        changes=tuple(changes),
        species_keys=names,
        species_sha256=tuple(file_hash(species_file(name)) for name in names),
        repertoire_sha256=tuple(file_hash(repertoire_file(name)) for name in names),
    )


def simulate(
    ticks: int, out: Path, scenario: str, fish: int | None, seed: int | None,
    changes: Sequence[str] = (), force: bool = False, tell: Callable[[str], None] = say,
) -> str:  # fmt: skip
    """Record `ticks` ticks of a world into `out`; returns the extent of the record in words.

    Ctrl-C leaves a valid file with the ticks so far. With `force` a file that is not a record is
    replaced, too. `tell` gets lines on the progress.
    """
    if out.suffix.lower() not in SUFFIXES:
        raise UserError(f"expected a name that ends in {' or '.join(SUFFIXES)}", file=out)
    check_result(out, record.RECORD, force)
    run = Run(scenario, ticks, seed, fish, tuple(changes))
    with interrupts.deferred_interrupts() as check:
        world = record_run(
            run, out, tell, lambda ticks: tqdm(ticks, unit="tick", disable=None), check
        )
    for line in world.notices:
        tell(line)
    return _extent(ticks, len(world.state.fishes.species))


def record_run(
    run: Run,
    out: Path,
    tell: Say = lambda message: None,
    progress: Callable[[Iterable[int]], Iterable[int]] = iter,
    check: Callable[[], None] = lambda: None,
) -> World:
    """Record a run into `out`; returns its world. Nobody steers the submarine.

    `tell` gets messages; `progress` wraps the iterable of ticks. `check` is called before each
    tick: if it raises KeyboardInterrupt, the file has the ticks so far.
    """
    loaded = load_scenario(run.scenario, run.changes)
    if len(run.changes) * max(map(len, run.changes), default=0) > MAX_CHANGES:
        raise UserError("--set: too long for a record; write a scenario file with these values")
    if not any(shoal.number for shoal in loaded.scenario.fish):
        raise UserError("has no fishes, nothing to record", file=loaded.path)
    world = ready_world(loaded, run.seed, tell, run.fish)
    number = len(world.state.fishes.species)
    length = int(np.clip(BLOCK_FISH_TICKS // number, 1, min(64, run.ticks)))
    block = _empty_block(length, number)
    held, happened, k = 0, [], 0
    names = _names(world)
    attributes = _attributes(world, names, provenance_of(*loaded, __file__))
    constants = _constants(world) | _coordinates(world)
    with hdf5.recording(out, attributes, constants, _notes(names), _SCALES) as append:
        try:
            for k in progress(range(run.ticks)):
                check()
                if k:  # the world is at its first tick when it has started
                    step(world, NEUTRAL)
                _note(world, block, held)
                happened += _begun(world)
                held += 1
                if held == length:
                    append(block | _table(happened))
                    held, happened = 0, []
        except KeyboardInterrupt:
            if not k:
                raise
            raise KeyboardInterrupt(f"{out}: {_extent(k, number)} kept") from None
        finally:
            if held:
                append({name: rows[:held] for name, rows in block.items()} | _table(happened))
    return world


def live_records(world: World, ticks: int, fish_ticks: int) -> Iterator[record.Record]:
    """Step a world for `ticks` ticks; yield records of at most `fish_ticks` each, in memory.

    `check`, which may raise, is called before each tick.
    """
    number = len(world.state.fishes.species)
    names = {name: list(words) for name, words in _names(world).items()}
    constants = _constants(world)
    done = 0
    while done < ticks:
        length = min(max(fish_ticks // number, 1), ticks - done)
        block = _empty_block(length, number)
        for row in range(length):
            if done + row:
                step(world, NEUTRAL)
            _note(world, block, row)
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
        )


def _extent(ticks: int, fishes: int) -> str:
    return f"{count_noun(ticks, 'tick', 'ticks')} of {count_noun(fishes, 'fish', 'fishes')}"


def _empty_block(length: int, n: int) -> Rows:
    """Make empty arrays for `length` ticks of `n` fishes."""
    sizes = {name: size for name, (_, size) in record.DIMENSIONS.items()}
    sizes |= {"time": length, "fish": n}
    return {
        name: np.zeros([sizes[k] or 0 for k in field.dimensions], field.type)
        for name, field in record.FIELDS.items()
        if field.dimensions[0] == "time"
    }


def _note(world: World, block: Rows, row: int) -> None:
    """Write the current tick into a row of the block."""
    state = world.state
    block["time"][row] = state.tick * TICK_S
    for name in ("position", "orientation", "velocity", "segment", "alive"):
        block[f"fish/{name}"][row] = getattr(state.fishes, name)
    ends_world(state.fishes, world.library.nodes, block["fish/snout"][row], block["fish/tail"][row])
    block["fish/centre"][row] = centres_world(
        state.fishes, world.library.nodes, world.dynamics.bodies.mass
    )
    block["fish/mental_state"][row] = state.minds.mental
    for name in ("intention", "leader", "target", "partner", "courtship", "last_meal"):
        block[f"fish/{name}"][row] = getattr(state.minds, name)
    block["plankton/count"][row] = (state.sea.absent <= 0.0).sum()
    block["day/hour"][row] = state.sea.sky[0]
    block["submarine/position"][row] = state.submarine.position


def _begun(world: World) -> list[Event]:
    """List the directions that began in the last tick."""
    log, tick = world.state.directions, world.state.tick
    return [
        (tick * TICK_S, int(k), (int(log.cast[k, 0]), int(log.cast[k, 1])))
        for k in np.flatnonzero(log.began == tick - 1)
    ]


def _table(happened: list[Event]) -> Rows:
    """Arrange events as rows of the record."""
    columns = zip(*happened, strict=True) if happened else ([], [], [])
    return {
        name: np.array([*column], record.FIELDS[name].type).reshape(-1, *ROLES[name])
        for name, column in zip(ROLES, columns, strict=True)
    }


def _constants(world: World) -> Rows:
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    outlines = [record.outline(species.surface) for species in world.species]
    values = {
        "fish/species": fishes.species,
        "fish/kind": minds.kind,
        "fish/male": minds.male,
        "fish/schools": minds.schools,
        "fish/length": fishes.length,
        "fish/snout_reach": fishes.snout,
        "species/half_width": np.array([width for width, _ in outlines]),
        "species/half_height": np.array([height for _, height in outlines]),
        "sea/heights": sea.heights,
        "sea/pillars": sea.pillars,
        "sea/rocks": sea.rocks,
    }
    return {name: np.asarray(given, record.FIELDS[name].type) for name, given in values.items()}


def _coordinates(world: World) -> Rows:
    """List labels and places along the dimensions; words are of any length, as netCDF has them."""
    sea = world.state.sea
    along = np.linspace(-sea.half_width, sea.half_width, len(sea.heights))
    words = {
        "axis": "xyz",
        "fish/component": "wxyz",
        "fish/drive": MENTAL_STATES,
        "species/species": [species.name for species in world.species],
        "sea/pillar_value": ("x", "y", "radius", "top"),
        "sea/rock_value": ("x", "y", "z", "half_axis_1", "half_axis_2", "half_axis_3", "rotation"),
    }
    return {
        "fish/fish": np.arange(len(world.state.fishes.species), dtype=np.int32),
        "species/station": np.linspace(0.0, 1.0, record.STATIONS),
        "sea/y": along,
        "sea/x": along,
        **{name: np.array([*labels], object) for name, labels in words.items()},
    }


def _names(world: World) -> dict[str, Sequence[str]]:
    """List the names of all codes and columns."""
    return {
        "species_names": [species.name for species in world.species],
        "kind_names": KINDS,
        "intention_names": INTENTIONS,
        "target_names": [TARGETS.get(name, "nothing") for name in INTENTIONS],
        "segment_names": SEGMENTS,
        "mental_state_names": MENTAL_STATES,
        "courtship_names": COURTSHIP,
        "direction_names": [one.name for one in world.scenario.direction],
    }


def _notes(names: Mapping[str, Sequence[str]]) -> dict[str, dict[str, Any]]:
    """List the attributes of each dataset, by the climate and forecast conventions (CF)."""
    notes: dict[str, dict[str, Any]] = {}
    for name, field in (record.FIELDS | record.COORDINATES).items():
        notes[name] = {"long_name": hdf5.text(field.meaning)}
        if field.unit:
            notes[name]["units"] = hdf5.text(field.unit)
        if field.type is np.bool_:
            notes[name]["dtype"] = hdf5.text("bool")  # else xarray reads numbers
        if name in CODES:
            meanings = [word.replace(" ", "_") for word in names[CODES[name]]]
            notes[name]["flag_values"] = np.arange(len(meanings), dtype=field.type)
            notes[name]["flag_meanings"] = hdf5.text(" ".join(meanings))
    return notes


def _attributes(
    world: World, names: Mapping[str, Sequence[str]], provenance: Provenance
) -> dict[str, Any]:
    """List the names of all codes, and everything needed to repeat the run."""
    bounds = world.scenario.bounds
    origin = {
        name: hdf5.text(value) if isinstance(value, str) else hdf5.words(value)
        for name, value in provenance._asdict().items()
        if name != "scenario"
    }
    return {
        "format": hdf5.text(record.FORMAT),
        "version": record.VERSION,
        "title": hdf5.text(world.scenario.title[:200]),
        **origin,
        "scenario": provenance.scenario,  # of any length; strings of fixed length hold 64 KB
        "tick_s": TICK_S,
        "seed": world.state.seed,
        "fish": len(world.state.fishes.species),
        "radius_cm": bounds.radius_cm,
        "depth_cm": bounds.depth_cm,
        "sea_half_width_cm": float(world.state.sea.half_width),
        **{name: hdf5.words(words) for name, words in names.items()},
        **{f"nature_{name}": value for name, value in world.nature._asdict().items()},
    }
