"""Write every tick of a world into a record, and by whom the world was moved."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from subsea import __version__
from subsea.base import hdf5, interrupts
from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.files import file_hash
from subsea.base.progress import count_noun
from subsea.base.source_stamp import source_stamp
from subsea.behavior.table import OURS
from subsea.behavior.teleop import TeleopCommands
from subsea.fish.species import repertoire_file, species_file
from subsea.geometry.periodic import laps_of
from subsea.lab.functions import described
from subsea.media import record
from subsea.motor.pose import centres_world, ends_world
from subsea.repertoire import SEGMENTS
from subsea.scenario.save import scenario_text
from subsea.scenario.schema import Scenario
from subsea.state import COURTSHIP, KINDS, MENTAL_STATES, Fishes
from subsea.submarine.vessel import NEUTRAL, STATION, Rail
from subsea.world.world import TICK_S, World

MAX_CHANGES = 15_000  # characters; an attribute holds 64 KB
BLOCK_FISH_TICKS = 200_000  # held in memory between two writes: about 16 MB
BLOCK_TICKS = 64  # at most

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
    found = inputs_of(scenario, source, changes, module)
    return found._replace(scenario=scenario_text(scenario, source))


def inputs_of(scenario: Scenario, source: Path, changes: Sequence[str], module: str) -> Provenance:
    """Collect the same without the text of the scenario, which its file and changes determine."""
    names = tuple(scenario.species)
    return Provenance(
        program=f"subsea {__version__}",
        packages=f"numpy {np.__version__}, numba {numba.__version__}",
        code_sha256=source_stamp(Path(module).resolve()),
        scenario="",
        scenario_sha256=file_hash(source),
        changes=tuple(changes),
        species_keys=names,
        species_sha256=tuple(file_hash(species_file(name)) for name in names),
        repertoire_sha256=tuple(file_hash(repertoire_file(name)) for name in names),
    )


def check_changes(changes: Sequence[str]) -> None:
    """Raise a UserError for changes that are too long for an attribute."""
    if len(changes) * max(map(len, changes), default=0) > MAX_CHANGES:
        raise UserError("--set: too long for a record; write a scenario file with these values")


class Recorder:
    """Collects ticks of a world in blocks and appends them to a file."""

    def __init__(self, world: World, out: Path, append: Callable[[Rows], None], most: int) -> None:
        """Begin with no tick; a block has at most `most` ticks."""
        number = len(world.state.fishes.species)
        length = int(np.clip(BLOCK_FISH_TICKS // number, 1, min(BLOCK_TICKS, most)))
        self.ticks = 0
        self.movers = dict.fromkeys(rules_of(world))  # by whom the world was moved so far
        self._out, self._append, self._number = out, append, number
        self._block, self._held = empty_block(length, number), 0
        self._laps = Laps(world)
        self._happened: list[Event] = []
        self._last = -1

    def note(self, world: World) -> None:
        """Add the last tick of a world; a UserError if the world did not go on by one tick."""
        tick = world.state.tick
        if self.ticks and tick != self._last + 1:
            raise UserError(
                f"the world went from tick {self._last} to {tick}, and a record is of one run; end "
                "it before `restore` or a new episode",
                file=self._out,
            )
        note(world, self._block, self._held, self._laps)
        self._happened += _begun(world)
        self.movers.update(dict.fromkeys(_movers(world)))
        self._last = tick
        self._held += 1
        self.ticks += 1
        if self._held == len(self._block["time"]):
            self.flush()

    def flush(self) -> None:
        """Append the ticks that are held, so that Ctrl-C cannot cut a block short."""
        if self._held:
            block = {name: rows[: self._held] for name, rows in self._block.items()}
            happened = self._happened
            self._held, self._happened = 0, []
            with interrupts.deferred_interrupts() as check:
                self._append(block | _table(happened))
            check()

    @property
    def extent(self) -> str:
        """The number of ticks and of fishes in words."""
        return extent(self.ticks, self._number)


@contextmanager
def recorder_of(
    world: World, out: Path, provenance: Provenance, most: int = BLOCK_TICKS
) -> Iterator[Recorder]:
    """Write a record `out` of the ticks that are noted inside; at most `most` ticks in a block.

    An interruption (KeyboardInterrupt) keeps the ticks so far, another fault leaves no file.
    """
    names = names_of(world)
    attributes = _attributes(world, names, provenance)
    constants = constants_of(world) | _coordinates(world)
    late: dict[str, Any] = {}
    with hdf5.recording(out, attributes, constants, _notes(names), _SCALES, late) as append:
        recorder = Recorder(world, out, append, most)
        try:
            yield recorder
        finally:
            recorder.flush()
            late["moved_by"] = hdf5.words(sorted(recorder.movers))


@contextmanager
def recorded(world: World, out: Path, provenance: Provenance) -> Iterator[None]:
    """Record into `out` every tick that a world makes inside, by any caller of `step`.

    An exception inside, as Ctrl-C, leaves a whole file of the ticks so far, which a note of the
    exception names, or no file without a tick. A UserError if no tick is made, or if the world does
    not go on by single ticks.
    """
    with ExitStack() as file:
        with interrupts.deferred_interrupts() as check:
            recorder = file.enter_context(recorder_of(world, out, provenance))
        check()
        world.observers.append(recorder.note)
        fault: BaseException | None = None
        try:
            yield
        except BaseException as inside:
            if not recorder.ticks:
                raise  # and no file
            fault = inside
        finally:
            world.observers.remove(recorder.note)
        if not recorder.ticks:
            raise UserError("the world made no tick, nothing to record", file=out)
        with interrupts.deferred_interrupts() as check:
            file.close()
        check()
        if fault is not None:
            fault.add_note(f"{out}: {recorder.extent} kept")
            raise fault


def _movers(world: World) -> Iterator[str]:
    """Name what steered the last tick: the minds of the fishes, teleop commands, a helm or rail."""
    order, alive = world.order, world.state.fishes.alive
    if isinstance(order, TeleopCommands):
        if len(order.fish):
            yield "teleop commands"
        if len(order.fish) >= alive.sum() and alive[order.fish].sum() >= alive.sum():
            return
    elif isinstance(order, Rail):
        yield "a rail of the submarine"
    elif order not in (None, NEUTRAL, STATION):
        yield "a helm of the submarine"
    yield "minds"


def rules_of(world: World) -> list[str]:
    """Describe the behaviors and senses of a world that are not ours."""
    ours = {id(one.routine) for one in OURS}
    return [
        *(
            f"behavior {one.name}: {described(one.routine)}"
            for one in world.table.behaviors
            if id(one.routine) not in ours
        ),
        *(f"sense: {described(one)}" for one in world.senses),
    ]


def extent(ticks: int, fishes: int) -> str:
    """Give the number of ticks and of fishes in words."""
    return f"{count_noun(ticks, 'tick', 'ticks')} of {count_noun(fishes, 'fish', 'fishes')}"


def empty_block(length: int, n: int) -> Rows:
    """Make empty arrays for `length` ticks of `n` fishes."""
    sizes = {name: size for name, (_, size) in record.DIMENSIONS.items()}
    sizes |= {"time": length, "fish": n}
    return {
        name: np.zeros([sizes[k] or 0 for k in field.dimensions], field.type)
        for name, field in record.FIELDS.items()
        if field.dimensions[0] == "time"
    }


class Laps:
    """Counts how often each fish left a box with periodic sides, so that records have whole paths.

    Places of a record go on beyond the sides: so differences in time are ways that a fish swam.
    """

    def __init__(self, world: World) -> None:
        """Begin with the fishes where they are."""
        self._before = world.state.fishes.position.copy()
        self._shift = np.zeros_like(self._before, np.float64)

    def shift(self, fishes: Fishes) -> Array:
        """Return how far (n, 3) the paths are beyond the places in the box; call once a tick."""
        if fishes.period[0]:
            lost = laps_of(self._before - fishes.position, fishes.period)
            self._shift[:, :2] += lost * fishes.period
            self._before[:] = fishes.position
        return self._shift


def note(world: World, block: Rows, row: int, laps: Laps) -> None:
    """Write the current tick into a row of the block."""
    state = world.state
    block["time"][row] = state.tick * TICK_S
    for name in ("position", "orientation", "velocity", "segment", "alive"):
        block[f"fish/{name}"][row] = getattr(state.fishes, name)
    ends_world(state.fishes, world.library.nodes, block["fish/snout"][row], block["fish/tail"][row])
    block["fish/centre"][row] = centres_world(
        state.fishes, world.library.nodes, world.dynamics.bodies.mass
    )
    if state.fishes.period[0]:
        shift = laps.shift(state.fishes)
        for name in ("position", "snout", "tail", "centre"):
            block[f"fish/{name}"][row] += shift
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


def constants_of(world: World) -> Rows:
    """Make the datasets that no tick changes."""
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


def names_of(world: World) -> dict[str, Sequence[str]]:
    """List the names of all codes and columns."""
    return {
        "species_names": [species.name for species in world.species],
        "kind_names": KINDS,
        "intention_names": world.table.names,
        "target_names": [TARGETS.get(name, "nothing") for name in world.table.names],
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
    bounds, period = world.scenario.bounds, world.state.fishes.period
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
        **(dict(zip(record.PERIODS, period.tolist(), strict=True)) if period[0] else {}),
        **{name: hdf5.words(words) for name, words in names.items()},
        **{f"nature_{name}": value for name, value in world.nature._asdict().items()},
    }
