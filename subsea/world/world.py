"""A world: what is constant in a dive, the state, and how both begin."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import file_digest
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.behavior.table import BEHAVIORS, DESIRES
from subsea.behavior.temperament import apply_individual, set_temperament
from subsea.core.arrays import Array
from subsea.core.disk_cache import kept
from subsea.core.errors import UserError
from subsea.core.toml_files import locate_errors
from subsea.directing import Script, make_script
from subsea.fish.coupling import Coupling, couple
from subsea.fish.species import Species, load_species, repertoire_file, species_file
from subsea.fish.surface import rest_control_points
from subsea.geometry.height_field import height_at
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import vector
from subsea.habitat.clearance import out_of_solids
from subsea.habitat.reef import grow_reefs
from subsea.habitat.rocks import rock_rows
from subsea.habitat.sea import make_sea, pillar_rows
from subsea.habitat.seaweed import plant_seaweed
from subsea.motor.switching import Dynamics, make_dynamics
from subsea.repertoire import SEGMENTS, Repertoire
from subsea.repertoire.library import Library, pack
from subsea.scenario.checks import check_scenario
from subsea.scenario.schema import MAX_SIMULATED, MAX_SOLIDS, Scenario, Shoal
from subsea.state import (
    HULL_CM,
    KINDS,
    TRAITS,
    Directions,
    Fishes,
    Live,
    Minds,
    Nature,
    Physics,
    Reef,
    Sea,
    Seaweed,
    State,
    Submarine,
    empty,
)
from subsea.submarine.course import check_tours

LIVE_REACH_CM = 500.0  # how near to the submarine a fish must be to be simulated

MOST_BYTES = 64 << 20  # of a repertoire that is kept once it is checked; those here have 2 at most
ROOM_BL = 0.6  # so many body lengths off every rock a fish begins
FLAT_BL = 0.4  # a body at least this tall, over its length, rows with its pectoral fins
RESOLVE_S = 60.0  # for so long fishes keep to the place that they are bound for first
TICK_S = 0.033  # one tick = one recorded frame = six steps of the simulation


@dataclass
class World:
    """All that a dive consists of."""

    scenario: Scenario
    species: tuple[Species, ...]
    library: Library
    dynamics: Dynamics
    nature: Nature
    current_cm_s: tuple[float, float]  # strength of the swinging current along x and y
    physics: Physics
    state: State
    tempers: dict[str, NDArray[Any]]  # what `TRAITS` were in the beginning
    script: Script  # of the scenario's directions
    stages_s: dict[str, float] = field(default_factory=dict)  # seconds of the last tick
    # Of fishes that go by what their eyes see: how bright that is, instead of the sea about them.
    seen_light: dict[int, float] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)  # lines to show: who shows them clears them
    told: set[tuple[int, Physics]] = field(default_factory=set)  # fishes that burst, and how

    @property
    def flowing_cm_s(self) -> tuple[float, float]:
        """`current_cm_s` with what directions add to it."""
        x, y = self.current_cm_s
        more = self.state.directions.current
        return (x + float(more[0]), y + float(more[1])) if len(more) else (x, y)

    def tell_burst(self, fishes: Iterable[int]) -> None:
        """Give notice of simulated fishes that lost their shape, once under the same physics."""
        how = self.physics._replace(fish=-1)  # not whom it acts on first
        new = [int(fish) for fish in fishes if (int(fish), how) not in self.told]
        if not new:
            return
        self.told.update((fish, how) for fish in new)
        names = [self.species[self.state.fishes.species[fish]].name for fish in new]
        who = " and ".join(f"{fish} ({name})" for fish, name in zip(new, names, strict=True))
        one = len(new) == 1
        self.notices.append(
            f"{'fish' if one else 'fishes'} {who} exploded, {_why(self.physics)}: "
            f"{'it is' if one else 'they are'} played back instead of simulated"
        )


def _why(physics: Physics) -> str:
    """What is unusual about physics, in words."""
    words = [
        f"{name.replace('_', ' ')} {value:g}"
        for name, value in physics._asdict().items()
        if name not in ("hydrodynamics", "fish") and value != Physics._field_defaults[name]
    ]
    words += [] if physics.hydrodynamics else ["hydrodynamics off"]
    return ", ".join(words) or "with the usual physics"


def create_world(
    scenario: Scenario,
    seed: int | None = None,
    fish: int | None = None,
    progress: Callable[[str], None] = lambda message: None,
    live: int | None = None,
    live_reach_cm: float = LIVE_REACH_CM,
    source: str = "the scenario",
) -> World:
    """Read the repertoires of a scenario's species and put everything in its place.

    `seed` replaces the scenario's; `fish` scales its shoals to that many fishes in all.
    `progress` is told what is going on. `live` fishes at most, None: as many as the scenario
    says, are simulated instead of played back: those nearest to the submarine, within
    `live_reach_cm`. A missing or damaged file, more live fishes than a picture can hold, or what
    would lie inside a rock, a pillar or the seabed is a UserError; `source` is the scenario's file.
    """
    live = scenario.simulated if live is None else live
    if live > MAX_SIMULATED:
        raise UserError(f"{live} fishes to simulate: expected at most {MAX_SIMULATED}")
    seed = scenario.seed if seed is None else seed
    progress("reading repertoires")
    names = scenario.species
    species = {name: _species(path := species_file(name), _stamp(path)) for name in names}
    files = [(repertoire_file(name), name) for name in names]
    repertoires = [_repertoire(path, name, _stamp(path)) for path, name in files]
    library = pack(repertoires, [_coupling(species[r.species], r) for r in repertoires], live)
    dynamics = make_dynamics([*species.values()], repertoires, library, live_reach_cm)
    recorded = len(library.entry)
    progress("shaping the seabed and growing the reef")
    rng = np.random.default_rng([seed, 0x5EA])
    with locate_errors(scenario, source):
        sea, reef, seaweed = _sea_of(scenario, rng, seed)
    progress("letting the fishes in")
    submarine = Submarine(position=np.array(scenario.submarine.position_cm, np.float64))
    submarine.angles[0] = np.radians(scenario.submarine.heading_deg)
    submarine.previous_position[:] = submarine.position
    submarine.lights[:] = scenario.submarine.lights
    submarine.previous_angles[:] = submarine.angles
    fishes, minds = _populate(scenario, species, library, sea, rng, fish)
    tables = {name: getattr(library, name) for name in ("rotation", "translation", "nodes")}
    told, many = len(scenario.direction), len(fishes.species)
    state = State(
        tick=0,
        seed=seed,
        fishes=fishes,
        minds=minds,
        sea=sea,
        seaweed=seaweed,
        reef=reef,
        submarine=submarine,
        live=empty(Live, k=live, given={name: table[recorded:] for name, table in tables.items()}),
        directions=empty(Directions, k=told, n=many if told else 0, axes=2 if told else 0),
    )
    nature = Nature(**msgspec.structs.asdict(scenario.nature))
    physics = Physics(**msgspec.structs.asdict(scenario.physics))
    return World(
        scenario, tuple(species.values()), library, dynamics, nature,
        scenario.water.current_cm_s, physics, state,
        {name: getattr(minds, name).copy() for name in TRAITS},
        make_script(scenario, _shares(scenario, fish), _fastest(fishes, library)),
    )  # fmt: skip


def check_world(scenario: Scenario, seed: int | None = None) -> None:
    """A UserError where `create_world` has one for a scenario that `check_scenario` lets pass."""
    seed = scenario.seed if seed is None else seed
    _sea_of(scenario, np.random.default_rng([seed, 0x5EA]), seed)


def check_in(scenario: Scenario, sea: Sea) -> None:
    """As `check_world`, at once: on the seabed and beside the reef of a `sea` that is nearly it."""

    def floor(x: float, y: float) -> float:
        return float(height_at(sea.heights, sea.half_width, x, y))

    check_scenario(scenario)
    _refuse_crowded(scenario)
    there = sea._replace(pillars=pillar_rows(scenario, floor), rocks=rock_rows(scenario, floor)[0])
    _refuse_too_high(scenario, there)
    _refuse_misplaced(scenario, there)


def _sea_of(scenario: Scenario, rng: np.random.Generator, seed: int) -> tuple[Sea, Reef, Seaweed]:
    """What surrounds the fishes, and stands and grows there; nothing in it is misplaced."""
    _refuse_crowded(scenario)
    sea = make_sea(scenario, rng)
    _refuse_too_high(scenario, sea)
    sea, reef = grow_reefs(scenario, sea)
    _refuse_misplaced(scenario, sea)
    check_tours(scenario, sea, rock_rows(scenario, lambda x, y: 0.0)[1])
    sea, seaweed = plant_seaweed(scenario, sea, reef, seed)
    return sea, reef, seaweed


def _stamp(path: Path) -> tuple[int, int] | None:
    """What differs when a file has changed; None without a file."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=64)
def _species(path: Path, stamp: object) -> Species:
    """A species, read once."""
    return load_species(str(path))


@lru_cache(maxsize=64)
def _repertoire(path: Path, name: str, stamp: object) -> Repertoire:
    """The repertoire of a species, which must be of that species and of this tick; read once."""
    if stamp is None:
        raise UserError(f"is not there; `subsea-capture record {name}` makes it", file=path)
    content = _content(path)
    repertoire = kept(_read, path, content) if content else _read(path, content)
    if repertoire.species != name:
        raise UserError(f"holds {repertoire.species!r}, expected {name!r}", file=path)
    if abs(repertoire.tick_s - TICK_S) > 1e-6:
        raise UserError(f"tick_s is {repertoire.tick_s:g}, expected {TICK_S:g}", file=path)
    return repertoire


def _content(path: Path) -> str:
    """A digest of a file; an empty one of what is no file, cannot be read or is far too large."""
    try:
        if not path.is_file() or path.stat().st_size > MOST_BYTES:
            return ""  # reading it says what is wrong
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def _read(path: Path, content: str) -> Repertoire:
    """The repertoire in a file of this content."""
    from subsea.repertoire import read_repertoire

    repertoire = read_repertoire(path)
    if _content(path) != content:  # else another's would be kept by its name
        raise UserError("was written anew while it was read; start again", file=path)
    return repertoire


def _coupling(species: Species, repertoire: Repertoire) -> Coupling:
    """How the surface of a species hangs on the nodes that its repertoire records."""
    nodes = repertoire.rest_nodes
    rest = rest_control_points(species.surface, repertoire.body_length_cm, nodes[0, 0])
    return couple(species.surface.coupling, nodes, rest)


def _refuse_crowded(scenario: Scenario) -> None:
    """A UserError for more rocks than a sea may have."""
    number = len(rock_rows(scenario, lambda x, y: 0.0)[0])
    if number > MAX_SOLIDS:
        raise UserError(
            f"{number} rocks in all, those of outcrops and arches counted, "
            f"expected at most {MAX_SOLIDS}"
        )


def _refuse_too_high(scenario: Scenario, sea: Sea) -> None:
    """A UserError for a pillar that is higher than the sea is deep there."""
    for k, top in enumerate(sea.pillars[:, 3]):
        if top > 0.0:
            given = scenario.pillar[k].height_cm
            raise UserError(
                f"`pillar[{k}].height_cm` {given:g} reaches above the surface, "
                f"expected at most {np.floor(given - top):g} there",
                key=f"pillar[{k}].height_cm",
            )


def _refuse_misplaced(scenario: Scenario, sea: Sea) -> None:
    """A UserError for what a scenario puts inside the seabed, the reef, a rock or a pillar."""
    _, rocks = rock_rows(scenario, lambda x, y: 0.0)
    places = [("submarine.position_cm", scenario.submarine.position_cm, HULL_CM)]
    for k, shoal in enumerate(scenario.fish):
        if shoal.position_cm is not None:
            places.append((f"fish[{k}].position_cm", shoal.position_cm, 0.0))
        if shoal.toward_cm is not None:
            places.append((f"fish[{k}].toward_cm", shoal.toward_cm, 0.0))
    if scenario.hook is not None:
        places.append(("hook", scenario.hook.bait_cm, 0.0))
    for k, one in enumerate(scenario.direction):
        here = f"direction[{k}]"
        if one.camera is not None and one.camera.position_cm is not None:
            places.append((f"{here}.camera.position_cm", one.camera.position_cm, HULL_CM))
        if one.place_cm is not None:
            places.append((f"{here}.place_cm", one.place_cm, 0.0))
        for i, point in enumerate(one.path_cm or ()):
            places.append((f"{here}.path_cm[{i}]", point, 0.0))
    for key, place, room in places:
        floor = height_at(sea.heights, sea.half_width, place[0], place[1])
        gaps = {"the seabed": place[2] - floor}
        if room:  # fishes are moved out of it
            over = height_at(sea.floor, sea.half_width, place[0], place[1])
            gaps["the reef"] = place[2] - over
        gaps |= {f"`pillar[{k}]`": from_pillar(row, place)[1] for k, row in enumerate(sea.pillars)}
        for name, row in zip(rocks, sea.rocks, strict=True):
            gaps[name] = min(from_rock(row, place)[1], gaps.get(name, np.inf))
        for name, gap in gaps.items():
            if gap < room:
                inside, outside = "inside", "outside"
                if name in ("the seabed", "the reef"):
                    inside, outside = "below", "above"
                where = f"lies {inside} {name}" if gap < 0.0 else f"is {gap:.1f} cm from {name}"
                expected = f"at least {room:g} cm off it" if room else f"{outside} it"
                raise UserError(f"`{key}` {place} {where}, expected {expected}", key=key)


def _shares(scenario: Scenario, fish: int | None) -> list[int]:
    """How many fishes each shoal has; scaled to `fish` in all by largest remainders."""
    numbers = np.array([shoal.number for shoal in scenario.fish])
    if fish is None or numbers.sum() == 0:
        return [int(n) for n in numbers]
    exact = numbers * fish / numbers.sum()
    shares = np.floor(exact).astype(int)
    for k in np.argsort(shares - exact, kind="stable")[: fish - int(shares.sum())]:
        shares[k] += 1
    return [int(n) for n in shares]


def _populate(
    scenario: Scenario,
    species: dict[str, Species],
    library: Library,
    sea: Sea,
    rng: np.random.Generator,
    fish: int | None,
) -> tuple[Fishes, Minds]:
    """All fishes at tick 0: places, sizes, leaders, tempers, each at its own phase of a swim."""
    shares = _shares(scenario, fish)
    fishes = empty(Fishes, n=sum(shares))
    minds = empty(Minds, n=sum(shares), b=len(BEHAVIORS), d=len(DESIRES))
    slow = SEGMENTS.index("swim_slow")
    first = 0
    for shoal, number in zip(scenario.fish, shares, strict=True):
        kind = list(species).index(shoal.species)
        these = slice(first, first + number)
        fishes.species[these] = kind
        smallest, largest = shoal.size_cm or species[shoal.species].size_cm
        fishes.length[these] = rng.uniform(smallest, largest, number)
        if shoal.leader_cm and number:
            fishes.length[first] = shoal.leader_cm
        fishes.identity[these] = rng.uniform(0, 1, number)
        schooling = species[shoal.species].schooling if shoal.schooling is None else shoal.schooling
        minds.schools[these] = schooling
        places = _places(shoal, number, scenario, rng)
        if shoal.leader_cm and shoal.position_cm:
            places[:1] = shoal.position_cm
        common = rng.uniform(-np.pi, np.pi)
        if shoal.heading_deg is not None:
            common = np.radians(shoal.heading_deg)
        together = schooling or shoal.heading_deg is not None
        for i, place in enumerate(places, start=first):
            room = ROOM_BL * float(fishes.length[i])
            place[:] = out_of_solids(sea, vector(place), room, 40.0, 40.0)
            turn = common + rng.normal(0, 0.2) if together else rng.uniform(-np.pi, np.pi)
            fishes.position[i] = place
            fishes.orientation[i] = heading_quaternion(turn)
            fishes.goal_direction[i] = np.cos(turn), np.sin(turn), 0.0
            row = int(rng.integers(library.length[kind, slow]))
            fishes.row_a[i] = library.first[kind, slow] + row
            fishes.row_b[i] = library.first[kind, slow] + (row + 1) % library.length[kind, slow]
        if schooling:
            minds.leader[first + 1 : first + number] = first
            minds.leads[first : first + 1] = number > 1
        minds.kind[these] = KINDS.index(shoal.kind or species[shoal.species].kind)
        set_temperament(shoal, fishes, minds, these, rng)
        minds.waypoint[these] = fishes.position[these]
        if shoal.toward_cm:
            minds.waypoint[these] = shoal.toward_cm
            minds.patience[these] = RESOLVE_S
        first += number
    for one in scenario.individual:
        if one.fish < len(fishes.species):  # else it is left out, with most of its shoal
            apply_individual(fishes, minds, one, 0.0)
    minds.urge[:] = fishes.goal_direction
    fishes.goal_speed[:] = 0.5
    fishes.segment[:] = slow
    fishes.wanted_segment[:] = slow
    fishes.scale[:] = fishes.length / library.recorded_length[fishes.species]
    fishes.snout[:] = fishes.scale * library.nodes[library.first[fishes.species, slow], 0, 0]
    fishes.girth[:] = fishes.length[:, None] * _girths([*species.values()], library)[fishes.species]
    # Froude similarity: a fish α times as long beats 1/√α as often.
    fishes.rate[:] = 1.0 / np.sqrt(fishes.scale)
    fishes.breath[:] = 2 * np.pi * fishes.identity
    fishes.fin_phase[:] = fishes.breath[:, None]
    flat = np.array([one.surface.depth > FLAT_BL for one in species.values()])
    fishes.oars[:] = flat[fishes.species]
    for name in ("position", "orientation", "row_a", "row_b", "weight", "span", "fins"):
        getattr(fishes, f"previous_{name}")[:] = getattr(fishes, name)
    return fishes, minds


def _fastest(fishes: Fishes, library: Library) -> Array:
    """How fast each fish is at most (n,), cm/s."""
    recorded = library.speed[fishes.species, SEGMENTS.index("swim_fast")]
    return np.asarray(recorded * fishes.scale * fishes.rate)


def _girths(species: list[Species], library: Library) -> Array:
    """How tall and how wide each species is (s, 2), body lengths: its widest cross-section."""
    rows = library.nodes[library.first[:, SEGMENTS.index("swim_slow")], 1:21]
    sections = rows.reshape(len(species), 5, 4, 3)
    wide = np.ptp(sections[..., 2], axis=2).max(axis=1) / library.recorded_length
    return np.stack([[one.surface.depth for one in species], wide], axis=1)


def _places(shoal: Shoal, number: int, scenario: Scenario, rng: np.random.Generator) -> Array:
    """Where the fishes of a shoal start (number, 3), cm, inside the cylinder."""
    radius = scenario.bounds.radius_cm
    if shoal.position_cm is None:
        angle = rng.uniform(0, 2 * np.pi, number)
        reach = 0.85 * radius * np.sqrt(rng.uniform(0, 1, number))
        depth = rng.uniform(-0.9, -0.3, number) * scenario.bounds.depth_cm
        return np.stack([reach * np.cos(angle), reach * np.sin(angle), depth], axis=1)
    # A shoal larger than the scenario's spreads, so that the space per fish stays the same.
    spread = shoal.spread_cm * max(1.0, number / max(shoal.number, 1)) ** (1 / 3)
    places = rng.normal(0, spread / 2, (number, 3)) * (1, 1, 0.5) + shoal.position_cm
    out = np.hypot(places[:, 0], places[:, 1]) / (0.85 * radius)
    places[:, :2] /= np.maximum(out, 1.0)[:, None]
    return np.asarray(places)


def heading_quaternion(heading: float) -> Array:
    """An upright body (4,) that heads `heading` rad left of the world's x axis."""
    # Body y is up and z is right: a quarter turn about x, then the heading about the vertical.
    c, s = np.cos(heading / 2), np.sin(heading / 2)
    r = np.sqrt(0.5)
    return np.array([c * r, c * r, s * r, s * r], np.float32)
