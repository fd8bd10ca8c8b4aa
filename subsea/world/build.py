"""Build a world from a scenario."""

from collections.abc import Callable, Sequence

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.language import marked
from subsea.base.toml_files import locate_errors
from subsea.base.validation import convert
from subsea.behavior.intention import Behavior
from subsea.behavior.table import with_behaviors
from subsea.fish.species import Species
from subsea.habitat.odour import make_odour, no_odour
from subsea.habitat.reef import grow_reefs
from subsea.habitat.sea import make_sea
from subsea.habitat.seaweed import plant_seaweed
from subsea.habitat.sites import lay_sites
from subsea.repertoire.library import LIVE_TABLES
from subsea.scenario.checks import check_scenario
from subsea.scenario.schema import MAX_SIMULATED, Scenario
from subsea.scenario.shoals import shoal_sizes
from subsea.state import (
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
from subsea.world.checks import check_sea, tour_fault
from subsea.world.populate import populate
from subsea.world.repertoires import motion_of, with_live
from subsea.world.world import World

LIVE_REACH_CM = 500.0  # greatest distance of a simulated fish from the submarine


def create_world(
    scenario: Scenario,
    seed: int | None = None,
    fish: int | None = None,
    progress: Callable[[str], None] = lambda message: None,
    live: int | None = None,
    live_reach_cm: float = LIVE_REACH_CM,
    source: str = "the scenario",
    behaviors: Sequence[Behavior] = (),
) -> World:
    """Create the world of a scenario at tick 0.

    `seed` overrides the scenario's; `fish` scales its shoals to that total number of fishes.
    `progress` receives messages. At most `live` fishes (None: as in the scenario), the nearest to
    the submarine within `live_reach_cm`, are simulated instead of played back. Raises a UserError
    for a missing or damaged file, too many live fishes, and things inside a rock, a pillar or the
    seabed; `source` is the scenario's file. `behaviors` come after ours, or replace one of the same
    name.
    """
    table = with_behaviors(behaviors)
    live = scenario.simulated if live is None else live
    if live > MAX_SIMULATED:
        raise UserError(f"{live} fishes to simulate: expected at most {MAX_SIMULATED}")
    seed = scenario.seed if seed is None else seed
    progress(marked("reading repertoires"))
    motion = motion_of(scenario.species)
    library = with_live(motion.library, live)
    progress(marked("shaping the seabed and growing the reef"))
    rng = np.random.default_rng([seed, 0x5EA])
    sea, reef, seaweed, owners = make_surroundings(scenario, rng, seed)
    submarine = Submarine(position=np.array(scenario.submarine.position_cm, np.float64))
    submarine.angles[0] = np.radians(scenario.submarine.heading_deg)
    submarine.previous_position[:] = submarine.position
    submarine.lights[:] = scenario.submarine.lights
    submarine.previous_angles[:] = submarine.angles
    numbers = shoal_sizes(scenario, fish)
    directed = bool(scenario.direction)
    tables = {name: getattr(library, name) for name in LIVE_TABLES}
    state = State(
        tick=0,
        seed=seed,
        fishes=empty(Fishes, n=sum(numbers), given={"period": period_of(scenario)}),
        minds=empty(Minds, n=sum(numbers), b=len(table.behaviors), d=len(table.desires)),
        sea=sea,
        seaweed=seaweed,
        odour=make_odour(sea) if _smells(scenario, motion.species) else no_odour(),
        reef=reef,
        submarine=submarine,
        live=empty(
            Live,
            k=live,
            given={name: table[len(library.entry) :] for name, table in tables.items()},
        ),
        directions=empty(
            Directions,
            k=len(scenario.direction),
            n=sum(numbers) * directed,
            axes=2 * directed,
        ),
    )
    world = World(
        scenario, motion.species, library, motion.dynamics._replace(reach_cm=live_reach_cm),
        Nature(**msgspec.structs.asdict(scenario.nature)), scenario.water.current_cm_s,
        Physics(**msgspec.structs.asdict(scenario.physics)), state, owners, numbers, table=table,
    )  # fmt: skip
    with locate_errors(world.scenario, source):
        check_sea(world.scenario, world.state.sea, world.rock_owners)
    if fault := tour_fault(world.scenario, world.state.sea, world.rock_owners):
        world.notices.append(f"{source}: {fault}")
    progress(marked("letting the fishes in"))
    populate(world, rng)
    return world


def period_of(scenario: Scenario) -> Array:
    """Return the period (2,) of the box of a scenario, cm; zeros without one."""
    return np.array(scenario.bounds.periodic_cm or (0.0, 0.0), np.float32)


def _smells(scenario: Scenario, species: Sequence[Species]) -> bool:
    """True if a scenario has a hook, or predators and prey, and water that carries odours.

    The water of a box does not: what leaves its cells would have to come in again.
    """
    by_name = dict(zip(scenario.species, species, strict=True))
    kinds = {shoal.kind or by_name[shoal.species].kind for shoal in scenario.fish}
    kinds |= {table.kind for table in scenario.individual if table.kind is not None}
    smelt = scenario.hook is not None or {"predator", "prey"} <= kinds
    return smelt and scenario.bounds.periodic_cm is None


def make_surroundings(
    scenario: Scenario, rng: np.random.Generator, seed: int
) -> tuple[Sea, Reef, Seaweed, list[str]]:
    """Make sea, reef and seaweed, with the scenario's table of each rock."""
    sea, owners = make_sea(scenario, rng)
    sea, reef = grow_reefs(scenario, sea)
    sea, seaweed = plant_seaweed(scenario, sea, reef, seed)
    sea = lay_sites(sea, reef)
    return sea, reef, seaweed, owners


def check_placed(scenario: Scenario, source: str = "the scenario", seed: int | None = None) -> None:
    """Raise a UserError if no world can be made of a scenario; takes up to a second."""
    seed = scenario.seed if seed is None else seed
    with locate_errors(scenario, source):
        convert(msgspec.to_builtins(scenario), Scenario)
        check_scenario(scenario)
        sea, _, _, owners = make_surroundings(scenario, np.random.default_rng([seed, 0x5EA]), seed)
        check_sea(scenario, sea, owners)
