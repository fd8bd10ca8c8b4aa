"""A scenario's sea for episodes of learning: what its steered fishes sense, see and do.

The world is built once. Each episode restores it and draws another key of all its random numbers
and, by `scatter` or `place`, where the steered fishes start. No fish is simulated: all move by
their repertoires.

Senses are what a fish's perception wrote into its mind, seen from the snout. Directions are unit
vectors in body axes: ahead, up, right. Nearness is s / (s + d) for a distance d from the snout and
the scale s of a group, so that it is 1 at contact and falls toward 0; 0 and a zero direction mean
nothing perceived. All numbers lie in [-1, 1].
"""

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Bytes, Ints
from subsea.base.errors import UserError, unknown
from subsea.behavior.teleop import TeleopCommands
from subsea.geometry.periodic import shortest
from subsea.geometry.rotation import matrix, x_axis
from subsea.geometry.solids import from_pillar, from_rock, height_at
from subsea.geometry.vector import vector
from subsea.habitat.contact import out_of_solids
from subsea.library import Changes, change_texts, render, retina
from subsea.library import World as LibraryWorld
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import with_total
from subsea.state import (
    CHOICES,
    FEAR,
    HUNGER,
    LIBIDO,
    NOBODY,
    PREDATOR,
    SEABED,
    SUBMARINE,
    SURFACE,
    WALL,
    Sea,
)
from subsea.submarine.vessel import STATION
from subsea.view.follow import FollowCamera, follow_fish
from subsea.world.build import create_world
from subsea.world.populate import heading_quaternion
from subsea.world.snapshot import changing
from subsea.world.step import step
from subsea.world.world import TICK_S, World

QUALITY = "low"  # of pictures


class FishPictures:
    """Draws one world; a UserError without OpenGL."""

    def __init__(self, world: World, size: tuple[int, int]) -> None:
        """Pictures from behind have `size` (width, height) pixels."""
        self._world, self._size = LibraryWorld(world), size
        self._camera: tuple[int, FollowCamera] | None = None

    def behind(self, fish: int) -> Bytes:
        """Draw the fish from behind (height, width, 3); the camera follows it smoothly."""
        before = self._camera[1] if self._camera and self._camera[0] == fish else None
        camera, pose = follow_fish(self._world.internal, fish, 1.0, before)
        self._camera = fish, camera
        return render(self._world, pose, self._size, QUALITY)

    def retina(self, fish: int, size: tuple[int, int]) -> Bytes:
        """Draw both eyes side by side (height, 2 width, 3), the left one first."""
        return np.concatenate(retina(self._world, fish, size, quality=QUALITY).picture, axis=1)


COMPANIONS = 3  # nearest neighbours that are listed
FASTEST_BL_S = 6.0  # body lengths per second that count as 1
# Scales of nearness, body lengths.
FOOD_BL, PREDATOR_BL, NEIGHBOUR_BL, OBSTACLE_BL = 1.0, 10.0, 2.0, 2.0

DIRECTION = ("ahead", "up", "right")
OWN = (
    "hunger", "libido", "fear", "light", "depth", "pitch", "gape",
    *(f"velocity {axis}" for axis in DIRECTION),
)  # fmt: skip
NAMES = (
    *OWN,
    *(f"food {k} {part}" for k in range(CHOICES) for part in (*DIRECTION, "nearness")),
    *(f"predator {k} {part}" for k in range(CHOICES) for part in (*DIRECTION, "nearness")),
    *(
        f"neighbour {k} {part}"
        for k in range(COMPANIONS)
        for part in (*DIRECTION, "nearness", *(f"heading {axis}" for axis in DIRECTION))
    ),
    *(f"threat {part}" for part in (*DIRECTION, "nearness")),
    *(f"barrier {part}" for part in (*DIRECTION, "nearness")),
)
"""The meaning of each number of `senses`. Prey is the food of predators."""


def senses(world: World, who: Ints) -> Array:
    """Sense what fishes `who` perceive: float32 (k, len(NAMES)) in [-1, 1]; 0 for dead fishes."""
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    axes = matrix(fishes.orientation[who].astype(np.float64))  # columns are the body axes
    length = fishes.length[who].astype(np.float64)
    ahead = axes[:, :, 0]
    snout = fishes.position[who] + fishes.snout[who, None] * ahead
    through = fishes.velocity[who] - fishes.drift[who].astype(np.float64)
    own = np.column_stack(
        [
            minds.mental[who][:, [HUNGER, LIBIDO, FEAR]], minds.light[who],
            -fishes.position[who, 2] / world.scenario.bounds.depth_cm, ahead[:, 2],
            fishes.gape[who], _to_body(axes, through) / (FASTEST_BL_S * length)[:, None],
        ]
    )  # fmt: skip

    def toward(places: Array, seen: Bools, scale_bl: float) -> Array:
        """Compute directions and nearness (k, 4 m) of places (k, m, 3) that are `seen` (k, m)."""
        gap = shortest(places - snout[:, None], fishes.period)
        distance = np.linalg.norm(gap, axis=2)
        way = _to_body(axes, gap) / np.maximum(distance, 1e-6)[..., None]
        scale = scale_bl * length[:, None]
        out = np.concatenate([way, (scale / (scale + distance))[..., None]], axis=2)
        return np.where(seen[..., None], out, 0.0).reshape(len(who), -1)

    foods, hunts = minds.foods[who], (minds.kind[who] == PREDATOR)[:, None]
    edible = foods >= 0
    prey = edible & hunts & fishes.alive[np.where(hunts, foods, 0)]
    specks = edible & ~hunts
    food_places = fishes.position[np.where(prey, foods, 0)].astype(np.float64)
    if len(sea.plankton):
        specks &= sea.absent[np.where(specks, foods, 0)] <= 0.0
        drifting = sea.plankton[np.where(specks, foods, 0)]
        food_places = np.where(hunts[..., None], food_places, drifting)
    feared = minds.predators[who]
    hull = (feared == SUBMARINE)[..., None]
    frightening = feared != NOBODY
    if world.nature.submarine_cm <= 0.0:  # then it is listed, but nobody minds it
        frightening &= feared != SUBMARINE
    feared_places = np.where(
        hull, sea.submarine[:3], fishes.position[np.maximum(feared, 0)].astype(np.float64)
    )
    near = minds.neighbour[who, :COMPANIONS]
    known = near != NOBODY
    near_places = fishes.position[np.maximum(near, 0)].astype(np.float64)
    headings = matrix(fishes.orientation[np.maximum(near, 0)].astype(np.float64))[..., 0]
    facing = np.where(known[..., None], _to_body(axes, headings), 0.0)
    company = np.concatenate(
        [toward(near_places, known, NEIGHBOUR_BL).reshape(len(who), COMPANIONS, 4), facing], axis=2
    )
    threat = minds.threat[who, None]
    threat_places = fishes.position[np.maximum(threat, 0)].astype(np.float64)
    barrier = minds.barrier[who]
    barrier_places = np.array(
        [barrier_place(sea, int(code), spot) for code, spot in zip(barrier, snout, strict=True)]
    )
    out = np.concatenate(
        [
            own,
            toward(food_places, prey | specks, FOOD_BL),
            toward(feared_places, frightening, PREDATOR_BL),
            company.reshape(len(who), -1),
            toward(threat_places, threat != NOBODY, OBSTACLE_BL),
            toward(barrier_places[:, None], (barrier != -1)[:, None], OBSTACLE_BL),
        ],
        axis=1,
    )
    out[~fishes.alive[who]] = 0.0
    return np.clip(out, -1.0, 1.0).astype(np.float32)


def barrier_place(sea: Sea, code: int, spot: Array) -> Array:
    """Find the nearest point (3,), cm, of an obstacle as `Minds.barrier` names it; none: `spot`."""
    if code == SEABED:
        return np.array([*spot[:2], height_at(sea.floor, sea.half_width, spot[0], spot[1])])
    if code == SURFACE:
        return np.array([*spot[:2], 0.0])
    if code == WALL:
        return np.array([*(sea.radius / max(np.hypot(*spot[:2]), 1e-6) * spot[:2]), spot[2]])
    if code < 0:
        return spot
    pillars = len(sea.pillars)
    near = from_pillar if code < pillars else from_rock
    solid = sea.pillars[code] if code < pillars else sea.rocks[code - pillars]
    normal, distance = near(solid, vector(spot))
    return np.asarray(spot - distance * np.array(normal))


def _to_body(axes: Array, vectors: Array) -> Array:
    """Turn world vectors (k, 3) or (k, m, 3) into body axes, the columns of `axes` (k, 3, 3)."""
    return np.asarray(np.einsum("kij,k...i->k...j", axes, vectors))


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
    """Make the options with these values; a UserError for an unknown one."""
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
        loaded = load_scenario(options.scenario, change_texts(options.changes))
        self.options = options
        self.scenario = with_total(loaded.scenario, options.fish_count)
        self.world = create_world(self.scenario, live=0, source=str(loaded.path))
        own = loaded._replace(scenario=self.scenario)
        self.library_world = LibraryWorld(self.world, options.scenario, own)
        for _ in range(SETTLE_TICKS):
            step(self.world, STATION)
        self._start = {name: array.copy() for name, array in changing(self.world).items()}
        self._start_tick = self.world.state.tick

        self._pictures: FishPictures | None = None

    @property
    def pictures(self) -> FishPictures:
        """Pictures of this sea; a UserError without OpenGL."""
        if self._pictures is None:
            self._pictures = FishPictures(self.world, self.options.picture_size)
        return self._pictures

    def close(self) -> None:
        """Release the renderer."""
        self._pictures = None

    @property
    def decisions_per_second(self) -> int:
        """Decisions in a second, rounded."""
        return round(1.0 / (self.options.ticks * TICK_S))

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
            eaten, before = minds.eaten[who], (self.world.state.tick - 0.5) * TICK_S
            step(self.world, order)
            # A digested stomach counts from 0 again.
            more = np.where(minds.eaten[who] > eaten, minds.eaten[who] - eaten, minds.eaten[who])
            # A direction that holds the hunger moves the last meal to an earlier time.
            meals += np.where(minds.last_meal[who] > before, more, 0.0)
        alive = self.world.state.fishes.alive[who]
        return Outcome(self.world, who, meals, alive, ticks * TICK_S)


def checked_action(action: Any, name: str = "action") -> Array:
    """Check an action (3,) as floats; a ValueError for another shape, NaN or infinity."""
    try:
        values = np.asarray(action, np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (len(ACTIONS),) or not np.isfinite(values).all():
        raise ValueError(f"{name}: expected 3 finite numbers (turn, rise, speed), got {action!r}")
    return values
