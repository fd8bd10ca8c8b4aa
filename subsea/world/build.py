"""Build a world from a scenario."""

from collections.abc import Callable

import msgspec
import numpy as np

from subsea.base.errors import UserError
from subsea.base.language import marked
from subsea.base.toml_files import locate_errors
from subsea.directing.script import make_script
from subsea.repertoire.library import LIVE_TABLES
from subsea.scenario.schema import MAX_SIMULATED, Scenario
from subsea.state import TRAITS, Directions, Live, Nature, Physics, State, Submarine, empty
from subsea.world.checks import make_surroundings, tour_fault
from subsea.world.populate import fastest_cm_s, populate, settle, shoal_sizes
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
) -> World:
    """Create the world of a scenario at tick 0.

    `seed` overrides the scenario's; `fish` scales its shoals to that total number of fishes.
    `progress` receives messages. At most `live` fishes (None: as in the scenario), the nearest to
    the submarine within `live_reach_cm`, are simulated instead of played back. Raises a UserError
    for a missing or damaged file, too many live fishes, and things inside a rock, a pillar or the
    seabed; `source` is the scenario's file.
    """
    live = scenario.simulated if live is None else live
    if live > MAX_SIMULATED:
        raise UserError(f"{live} fishes to simulate: expected at most {MAX_SIMULATED}")
    seed = scenario.seed if seed is None else seed
    progress(marked("reading repertoires"))
    recorded = motion_of(scenario.species)
    species = dict(zip(scenario.species, recorded.species, strict=True))
    library = with_live(recorded.library, live)
    dynamics = recorded.dynamics._replace(reach_cm=live_reach_cm)
    progress(marked("shaping the seabed and growing the reef"))
    rng = np.random.default_rng([seed, 0x5EA])
    with locate_errors(scenario, source):
        sea, reef, seaweed = make_surroundings(scenario, rng, seed)
    progress(marked("letting the fishes in"))
    submarine = Submarine(position=np.array(scenario.submarine.position_cm, np.float64))
    submarine.angles[0] = np.radians(scenario.submarine.heading_deg)
    submarine.previous_position[:] = submarine.position
    submarine.lights[:] = scenario.submarine.lights
    submarine.previous_angles[:] = submarine.angles
    fishes, minds = populate(scenario, species, library, sea, rng, fish)
    settle(species, fishes, minds, reef)
    tables = {name: getattr(library, name) for name in LIVE_TABLES}
    directed = bool(scenario.direction)
    state = State(
        tick=0,
        seed=seed,
        fishes=fishes,
        minds=minds,
        sea=sea,
        seaweed=seaweed,
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
            n=len(fishes.species) * directed,
            axes=2 * directed,
        ),
    )
    nature = Nature(**msgspec.structs.asdict(scenario.nature))
    physics = Physics(**msgspec.structs.asdict(scenario.physics))
    world = World(
        scenario, tuple(species.values()), library, dynamics, nature,
        scenario.water.current_cm_s, physics, state,
        {name: getattr(minds, name).copy() for name in TRAITS},
        make_script(scenario, shoal_sizes(scenario, fish), fastest_cm_s(fishes, library)),
    )  # fmt: skip
    if fault := tour_fault(scenario, sea):
        world.notices.append(f"{source}: {fault}")
    return world
