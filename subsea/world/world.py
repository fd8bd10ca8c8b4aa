"""A world: the constants of a dive, and the state."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.behavior.intention import Routine
from subsea.behavior.table import TABLE, BehaviorTable
from subsea.directing.script import Script, make_script
from subsea.fish.species import Species
from subsea.habitat.current import REACH_CM, flow_at
from subsea.habitat.rocks import RockCells, rock_cells
from subsea.motor.switching import Dynamics
from subsea.perception.sites import SiteGrids, grids_of
from subsea.repertoire.library import Library
from subsea.scenario.schema import Scenario
from subsea.state import Nature, Physics, State

TICK_S = 0.033  # one tick = one recorded frame = six steps of the simulation


@dataclass
class World:
    """Constants and state of a dive."""

    scenario: Scenario
    species: tuple[Species, ...]
    library: Library
    dynamics: Dynamics
    nature: Nature
    current_cm_s: tuple[float, float]  # strength of the swinging current along x and y
    physics: Physics
    state: State
    rock_owners: list[str]  # the scenario's table of each rock
    shoal_sizes: list[int]  # number of fishes of each shoal
    script: Script = field(init=False)  # of the scenario's directions
    # Values of `state.TRAITS` before panels changed any.
    initial_traits: dict[str, NDArray[Any]] = field(default_factory=dict)
    stages_s: dict[str, float] = field(default_factory=dict)  # seconds of the last tick
    # Brightness of rendered eye views, for fishes that use it in place of the ambient light.
    seen_light: dict[int, float] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)  # lines to show, cleared by the reader
    # Functions to call after every tick.
    observers: list[Callable[["World"], object]] = field(default_factory=list)
    reported_bursts: set[tuple[int, Physics]] = field(default_factory=set)
    table: BehaviorTable = TABLE  # its behaviors and their desires
    # Functions that perceive more for the fishes that think, after their own senses.
    senses: tuple[Routine, ...] = ()
    order: object = None  # the order of the last tick, as `step` takes it
    levels: bool = False  # true in a dive in which far fishes think less often
    # The rocks, and the cells that list these rocks.
    _listed: tuple[Array, RockCells] | None = field(default=None, init=False, repr=False)
    # The sites, and these sorted by kind.
    _sorted: tuple[Array, SiteGrids] | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        """Resolve the directions."""
        self.script = make_script(self.scenario, self.shoal_sizes)

    @property
    def rock_cells(self) -> RockCells:
        """Return the rocks by the cells where they change the current."""
        rocks = self.state.sea.rocks
        if self._listed is None or self._listed[0] is not rocks:
            self._listed = rocks, rock_cells(rocks, REACH_CM)
        return self._listed[1]

    @property
    def site_grids(self) -> SiteGrids:
        """Return the sites of the sea, sorted by kind."""
        places = self.state.sea.site_place
        if self._sorted is None or self._sorted[0] is not places:
            self._sorted = places, grids_of(self.state.sea)
        return self._sorted[1]

    @property
    def flowing_cm_s(self) -> tuple[float, float]:
        """Add the current of directions to `current_cm_s`."""
        x, y = self.current_cm_s
        more = self.state.directions.current
        return (x + float(more[0]), y + float(more[1])) if len(more) else (x, y)

    def flow(self) -> Array:
        """Compute the velocity (3,) of the uniform current at the present tick, cm/s."""
        now_s = self.state.tick * TICK_S
        return flow_at(self.flowing_cm_s, now_s, self.scenario.water.stream_cm_s)

    def report_bursts(self, fishes: Iterable[int]) -> None:
        """Add a notice of simulated fishes that lost their shape, once for each physics."""
        how = self.physics._replace(fish=-1)  # whichever is simulated first
        new = [int(fish) for fish in fishes if (int(fish), how) not in self.reported_bursts]
        if not new:
            return
        self.reported_bursts.update((fish, how) for fish in new)
        names = [self.species[self.state.fishes.species[fish]].name for fish in new]
        who = " and ".join(f"{fish} ({name})" for fish, name in zip(new, names, strict=True))
        single = len(new) == 1
        self.notices.append(
            f"{'fish' if single else 'fishes'} {who} exploded, {_unusual(self.physics)}: "
            f"{'it is' if single else 'they are'} played back instead of simulated"
        )


def _unusual(physics: Physics) -> str:
    """Name the parameters that differ from the usual physics."""
    words = [
        f"{name.replace('_', ' ')} {value:g}"
        for name, value in physics._asdict().items()
        if name not in ("hydrodynamics", "fish") and value != Physics._field_defaults[name]
    ]
    words += [] if physics.hydrodynamics else ["hydrodynamics off"]
    return ", ".join(words) or "with the usual physics"
