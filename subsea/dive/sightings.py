"""Find which species and which behaviors a visitor can recognise in the picture ahead."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.language import marked
from subsea.state import (
    BATHE,
    CLEAN,
    CURIOUS,
    ESCAPE,
    GRAZE,
    GUARD,
    LOOPING,
    POSE,
    PREDATOR,
    RUSHING,
    SCHOOL,
    SHELTER,
    SPAWNING,
    STALKING,
)
from subsea.view.front_screen import FrontView
from subsea.world.world import TICK_S, World

LEAST_SHARE = 0.06  # length of a fish in the picture, share of its height
LEAST_SPECK = 0.02  # the same for each fish of a group that does something together
MARGIN = 0.05  # the outer part of the picture does not count
CLEAR = 0.7  # share of the visibility within which a fish is recognised
MEAL_S = 1.0  # a catch is seen for this time
NEAR_CM = 250.0  # a curious fish has come to the vessel
TOUCHING = 1.5  # greatest distance from an anemone or a client, in lengths
GROUP = 8  # fewest fishes of a mill or a flight
# Of a mill: rotation at least, polarisation at most (Tunstrøm et al., PLoS Comput. Biol. 2013).
ROTATES, POLARISED = 0.65, 0.35


class Sighting(NamedTuple):
    """A subject, and the fish that shows it."""

    subject: str  # the name of a species, or a key of BEHAVIORS
    fish: int
    x: float  # place of the fish in the picture, shares from its upper left
    y: float
    size: float  # its length, share of the height of the picture; 1 for a group


class SeenBehavior(NamedTuple):
    """A behavior in the logbook."""

    title: str
    hint: str  # where to look for it
    shows: Callable[[World, Ints], Bools]
    together: bool = False  # a group shows it


def _intends(code: int) -> Callable[[World, Ints], Bools]:
    return lambda world, who: world.state.minds.intention[who] == code


def _courts(world: World, who: Ints) -> Bools:
    courtship = world.state.minds.courtship[who]
    return (courtship >= LOOPING) & (courtship < SPAWNING)


def _spawns(world: World, who: Ints) -> Bools:
    return world.state.minds.courtship[who] == SPAWNING


def _hunts(world: World, who: Ints) -> Bools:
    minds = world.state.minds
    phase = minds.hunt[who]
    return (minds.kind[who] == PREDATOR) & ((phase == STALKING) | (phase == RUSHING))


def _catches(world: World, who: Ints) -> Bools:
    minds, now_s = world.state.minds, world.state.tick * TICK_S
    fed = (minds.last_meal[who] > 0.0) & (now_s - minds.last_meal[who] < MEAL_S)
    return (minds.kind[who] == PREDATOR) & fed


def _cleans(world: World, who: Ints) -> Bools:
    fishes, minds = world.state.fishes, world.state.minds
    client = minds.client[who]
    gap = np.linalg.norm(fishes.position[client] - fishes.position[who], axis=1)
    near = gap < TOUCHING * fishes.length[client]
    return (minds.intention[who] == CLEAN) & (client >= 0) & near


def _feeds_on_stone(world: World, who: Ints) -> Bools:
    return (world.state.minds.intention[who] == GRAZE) & world.state.fishes.close[who]


def _bathes(world: World, who: Ints) -> Bools:
    fishes, minds = world.state.fishes, world.state.minds
    bathes = (minds.intention[who] == BATHE) & (minds.cover[who] >= 0)
    if not bathes.any():
        return bathes  # the sea may be without any site
    place = world.state.sea.site_place[np.where(bathes, minds.cover[who], 0)]
    gap = np.linalg.norm(place - fishes.position[who], axis=1)
    return bathes & (gap < TOUCHING * fishes.length[who])


def _visits(world: World, who: Ints) -> Bools:
    fishes, submarine = world.state.fishes, world.state.submarine
    gap = np.linalg.norm(fishes.position[who] - submarine.position, axis=1)
    return (world.state.minds.intention[who] == CURIOUS) & (gap < NEAR_CM)


def _schools(world: World, who: Ints) -> Bools:
    return world.state.minds.schools[who] & (world.state.minds.intention[who] == SCHOOL)


def _flees(world: World, who: Ints) -> Bools:
    flees = world.state.minds.intention[who] == ESCAPE
    return flees & (np.count_nonzero(flees) >= GROUP)


def _mills(world: World, who: Ints) -> Bools:
    """Tell which fishes are in a mill: all schooling ones of a species whose school rotates."""
    fishes = world.state.fishes
    schools, mills = _schools(world, who), np.zeros(len(who), bool)
    for species in np.unique(fishes.species[who[schools]]):
        those = schools & (fishes.species[who] == species)
        mills |= those & _rotates(fishes.position[who[those]], fishes.velocity[who[those]])
    return mills


def _rotates(position: Array, velocity: Array) -> bool:
    """True if fishes at (n, 3) positions with (n, 3) velocities circle a common centre."""
    speed = np.linalg.norm(velocity, axis=1, keepdims=True)
    if len(position) < GROUP or (speed < 1e-3).any():
        return False
    heading = velocity / speed
    out = position - position.mean(axis=0)
    out /= np.linalg.norm(out, axis=1, keepdims=True) + 1e-6
    rotation = np.linalg.norm(np.cross(out, heading).mean(axis=0))
    return bool(rotation > ROTATES and np.linalg.norm(heading.mean(axis=0)) < POLARISED)


BEHAVIORS = {
    "school": SeenBehavior(
        marked("A school"),
        marked("Silversides and fusiliers school in the open water."), _schools, True,
    ),
    "mill": SeenBehavior(
        marked("A mill"),
        marked("A large school that meets itself may begin to circle."), _mills, True,
    ),
    "flight": SeenBehavior(
        marked("A flight"), marked("Wait beside a school for a shark."), _flees, True
    ),
    "hunt": SeenBehavior(
        marked("A hunt"), marked("Follow a shark: it stalks from below."), _hunts
    ),
    "catch": SeenBehavior(
        marked("A catch"), marked("Only some rushes of a shark end so."), _catches
    ),
    "courtship": SeenBehavior(
        marked("Courtship"), marked("At dusk two reef fishes circle each other."), _courts
    ),
    "spawning": SeenBehavior(
        marked("Spawning"), marked("At dusk a pair rises and darts apart."), _spawns
    ),
    "cleaning": SeenBehavior(
        marked("A cleaning station"),
        marked("A fish that holds still, fins spread, waits for a wrasse."), _cleans,
    ),
    "posing": SeenBehavior(
        marked("A client"), marked("It poses near a wrasse to be cleaned."), _intends(POSE)
    ),
    "grazing": SeenBehavior(
        marked("A meal on the stone"),
        marked("Go close to a rock where tangs or butterflyfishes feed."), _feeds_on_stone,
    ),
    "anemone": SeenBehavior(
        marked("At home in an anemone"), marked("Look for a clownfish near the sand."), _bathes
    ),
    "chase": SeenBehavior(
        marked("A quarrel"), marked("A clownfish drives others from its anemone."),
        _intends(GUARD),
    ),
    "shelter": SeenBehavior(
        marked("Under cover"), marked("By night and from sharks, fishes hide in the reef."),
        _intends(SHELTER),
    ),
    "visit": SeenBehavior(
        marked("A fish that visits you"), marked("Stop, and let a curious fish come to you."),
        _visits,
    ),
}  # fmt: skip
"""Behaviors in the order of the logbook."""


def sightings(world: World, front: FrontView, alpha: float) -> Iterator[Sighting]:
    """Yield what a visitor can recognise on the front screen at `alpha` between two ticks.

    Each subject comes once, with the fish that is largest in the picture.
    """
    fishes = world.state.fishes
    place = fishes.previous_position + alpha * (fishes.position - fishes.previous_position)
    at = front.places(place)
    far = np.linalg.norm(place - np.asarray(front.view.eye), axis=1)
    focal = float(front.view.projection[1, 1]) / max(front.high[1] - front.low[1], 1e-6)
    size = focal * fishes.length / np.maximum(far, 1.0)  # shares of the height of the screen
    with np.errstate(invalid="ignore"):
        inside = ((at > MARGIN) & (at < 1.0 - MARGIN)).all(axis=1)
    clear = fishes.alive & inside & (far < CLEAR * world.scenario.water.visibility_cm)
    many = np.flatnonzero(clear & (size > LEAST_SPECK))
    many = many[np.argsort(-size[many], kind="stable")]
    single = many[size[many] > LEAST_SHARE]
    for species in dict.fromkeys(fishes.species[single].tolist()):
        fish = int(single[fishes.species[single] == species][0])
        x, y, large = float(at[fish, 0]), float(at[fish, 1]), float(size[fish])
        yield Sighting(world.species[species].name, fish, x, y, large)
    for name, (_, _, shows, together) in BEHAVIORS.items():
        who = many if together else single
        showing = who[shows(world, who)] if len(who) else who
        if len(showing) >= (GROUP if together else 1):
            fish = int(showing[0])
            x, y = float(at[fish, 0]), float(at[fish, 1])
            yield Sighting(name, fish, x, y, 1.0 if together else float(size[fish]))
