"""A scenario's sea for episodes of learning, in which chosen fishes are steered.

The world is built once. Each episode restores it and draws another key of all its random numbers
and, by `scatter` or `place`, where the steered fishes start. No fish is simulated: all move by
their repertoires.
"""

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.errors import UserError, unknown
from subsea.behavior.teleop import TeleopCommands
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import vector
from subsea.habitat.clearance import out_of_solids
from subsea.library.world import Changes, change_texts
from subsea.scenario.load import load_scenario
from subsea.submarine.helm import STATION
from subsea.world.build import create_world
from subsea.world.populate import heading_quaternion, with_total
from subsea.world.snapshot import changing
from subsea.world.step import step
from subsea.world.world import TICK_S

SETTLE_TICKS = 30  # until the fishes of a new world have found their neighbours
MAX_KEY = 2**31  # of an episode's random numbers
SHARE_OF_RADIUS = 0.85  # within which fishes start
ABOVE_CM, BELOW_CM = 40.0, 40.0  # least distances of a start from the ground and the surface
ACTIONS = ("turn", "rise", "speed")  # components of an action, see `TeleopCommand`


@dataclass(frozen=True)
class SeaOptions:
    """Options of every environment of a living sea."""

    scenario: str = "peaceful"  # a name or a file
    fish_count: int | None = None  # scales the shoals to this total; None: as in the scenario
    changes: Changes = ()  # of the scenario, as of `subsea.load`
    ticks: int = 3  # of 33 ms between two decisions
    max_steps: int = 600  # decisions after which an episode is truncated
    retina_size: tuple[int, int] = (64, 64)  # pixels of each eye
    picture_size: tuple[int, int] = (480, 360)  # pixels of rendered pictures

    def __post_init__(self) -> None:
        """Refuse numbers below 1."""
        sizes = (self.ticks, self.max_steps, *self.retina_size, *self.picture_size)
        if not all(isinstance(size, int | np.integer) and size >= 1 for size in sizes):
            raise UserError("ticks, max_steps, retina_size, picture_size: whole numbers from 1")


def sea_options(default_scenario: str, given: dict[str, Any]) -> SeaOptions:
    """The options with these values; a UserError for an unknown one."""
    known = [field.name for field in fields(SeaOptions)]
    for name in given:
        if name not in known:
            raise unknown("option", name, known)
    return SeaOptions(**({"scenario": default_scenario} | given))


class Outcome(NamedTuple):
    """The result of a decision for k fishes, which rewards read."""

    world: Any  # `subsea.world.world.World`, after the decision
    fish: Ints  # (k,) their indices
    meals: Array  # (k,) specks or prey eaten since the last decision
    alive: Bools  # (k,)
    seconds: float  # time since the last decision


class LivingSea:
    """A sea whose episodes begin alike, except for what the random numbers decide."""

    def __init__(self, options: SeaOptions) -> None:
        """Build the world of the scenario with its own seed."""
        scenario, source = load_scenario(options.scenario, change_texts(options.changes))
        self.options, self.scenario = options, with_total(scenario, options.fish_count)
        self.world = create_world(self.scenario, live=0, source=str(source))
        for _ in range(SETTLE_TICKS):
            step(self.world, STATION)
        self._start = {name: array.copy() for name, array in changing(self.world).items()}
        self._start_tick = self.world.state.tick

    @property
    def species(self) -> list[str]:
        """The species of each fish, as scenarios name them."""
        names = self.scenario.species
        return [names[kind] for kind in self.world.state.fishes.species]

    def begin(self, rng: np.random.Generator) -> None:
        """Restore the start of an episode."""
        for name, array in changing(self.world).items():
            array[...] = self._start[name]
        self.world.state.tick = self._start_tick
        self.world.state.seed = int(rng.integers(MAX_KEY))
        self.world.seen_light.clear()
        self.world.notices.clear()

    def scatter(self, who: Ints, rng: np.random.Generator, spread_cm: float) -> None:
        """Move the fishes `who` by up to about `spread_cm`, and turn each at random."""
        for i in who:
            here = self.world.state.fishes.position[i]
            self.place(int(i), here + rng.normal(0.0, spread_cm / 2, 3), rng.uniform(-np.pi, np.pi))

    def turn(self, who: Ints, rng: np.random.Generator, spread_cm: float, most_rad: float) -> None:
        """Move the fishes `who` likewise, and turn each by at most `most_rad`: schools remain."""
        for i in who:
            here = self.world.state.fishes.position[i]
            ahead = x_axis(self.world.state.fishes.orientation[i])
            heading = np.arctan2(ahead[1], ahead[0]) + rng.uniform(-most_rad, most_rad)
            self.place(int(i), here + rng.normal(0.0, spread_cm / 2, 3), heading)

    def place(self, i: int, place: Array, heading: float) -> None:
        """Put fish i at rest near a place (3,), cm, clear of solids, with a heading in rad."""
        state, fishes = self.world.state, self.world.state.fishes
        away = np.hypot(place[0], place[1]) / (SHARE_OF_RADIUS * state.sea.radius)
        spot = vector(np.append(place[:2] / max(away, 1.0), place[2]))
        room = float(fishes.length[i])
        fishes.position[i] = out_of_solids(state.sea, spot, room, ABOVE_CM + room, BELOW_CM + room)
        fishes.orientation[i] = heading_quaternion(heading)
        fishes.goal_direction[i] = state.minds.urge[i] = np.cos(heading), np.sin(heading), 0.0
        fishes.velocity[i] = 0.0
        fishes.previous_position[i] = fishes.position[i]
        fishes.previous_orientation[i] = fishes.orientation[i]

    def advance(self, who: Ints, actions: Array | None, ticks: int | None = None) -> Outcome:
        """Steer the fishes `who` (k,) by `actions` (k, 3) until the next decision.

        Without actions they follow their own minds. Steered fishes eat what is before their
        mouths. Actions are clipped to [-1, 1].
        """
        minds, ticks = self.world.state.minds, self.options.ticks if ticks is None else ticks
        order: Any = STATION
        if actions is not None:
            turn, rise, speed = np.clip(np.asarray(actions, np.float64), -1.0, 1.0).T.copy()
            order = TeleopCommands(who, turn, rise, speed, np.ones(len(who), np.bool_))
        meals = np.zeros(len(who))
        for _ in range(ticks):
            eaten, before = minds.eaten[who], minds.last_meal[who]
            step(self.world, order)
            # A digested stomach counts from 0 again.
            more = np.where(minds.eaten[who] > eaten, minds.eaten[who] - eaten, minds.eaten[who])
            meals += np.where(minds.last_meal[who] != before, more, 0.0)
        alive = self.world.state.fishes.alive[who]
        return Outcome(self.world, who, meals, alive, ticks * TICK_S)


def checked_action(action: Any, name: str = "action") -> Array:
    """An action (3,) as floats; a ValueError for another shape, NaN or infinity."""
    try:
        values = np.asarray(action, np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (len(ACTIONS),) or not np.isfinite(values).all():
        raise ValueError(f"{name}: expected 3 finite numbers (turn, rise, speed), got {action!r}")
    return values
