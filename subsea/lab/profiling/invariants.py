"""Invariants of a world: checks after a tick, and checks over minutes."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.geometry.solids import height_at
from subsea.habitat.contact import clearances
from subsea.state import HUNGER, Sea
from subsea.submarine.vessel import AHEAD_CM_S, MAX_PITCH
from subsea.world import snapshot
from subsea.world.world import TICK_S, World

MAX_DEPTH_BL = 0.25  # of a fish's middle inside rock, body lengths
MAX_BL_S, MAX_DRIFT_CM_S = 12.0, 150.0  # speed of a fish: body lengths, and carried by water
OFF_UNIT = 1e-3  # tolerance of the length of a quaternion
STILL_BL = 0.5  # a fish that stays in a box of this size, in body lengths, does not move
SHARES = (
    "fishes.weight", "fishes.gape", "fishes.display", "minds.mental", "minds.light",
    "minds.menace", "minds.menaces",
)  # fmt: skip
QUATERNIONS = ("fishes.orientation", "fishes.previous_orientation")
SLACK = 1e-5  # for rounding


def faults_in(world: World) -> list[str]:
    """Faults of a world: impossible values, bodies in impossible places."""
    try:
        snapshot.check(world)
    except UserError as fault:
        return [str(fault)]
    return [*_odd_numbers(world), *_misplaced(world), *_too_fast(world)]


def _odd_numbers(world: World) -> Iterator[str]:
    """Shares outside 0 to 1, and quaternions that are not of unit length."""
    arrays = snapshot.changing(world)
    for name in SHARES:
        for where in np.argwhere((arrays[name] < -SLACK) | (arrays[name] > 1.0 + SLACK))[:1]:
            k = tuple(int(index) for index in where)
            yield f"{name}{[*k]} is {arrays[name][k]:g}, expected a share"
    for name in QUATERNIONS:
        length = np.linalg.norm(arrays[name], axis=1)
        for k in np.flatnonzero(np.abs(length - 1.0) > OFF_UNIT)[:1]:
            yield f"{name}[{k}] is a quaternion of length {length[k]:g}"


def _misplaced(world: World) -> Iterator[str]:
    """Fishes, the submarine and plankton outside the sea or inside rock."""
    sea, fishes, submarine = world.state.sea, world.state.fishes, world.state.submarine
    swims = in_water(world)
    names = [*(f"fish {i}" for i in swims), "the submarine"]
    places = np.concatenate([fishes.position[swims], submarine.position[None]])
    allowed = np.append(MAX_DEPTH_BL * fishes.length[swims], 0.0)
    out, deep = out_of_sea(places, sea), depth_in_rock(places, sea)
    for k in np.flatnonzero(out):
        yield f"{names[k]} is out of the sea, at {_words(places[k])}"
    for k in np.flatnonzero(deep > allowed):
        yield f"{names[k]} is {deep[k]:.0f} cm inside rock, at {_words(places[k])}"
    there = sea.plankton[sea.absent == 0.0]
    for k in np.flatnonzero(out_of_sea(there, sea))[:1]:
        yield f"a speck of plankton is out of the sea, at {_words(there[k])}"


def _too_fast(world: World) -> Iterator[str]:
    """Speeds beyond those of muscles and propeller."""
    fishes, submarine = world.state.fishes, world.state.submarine
    swims = in_water(world)
    way = fishes.position[swims] - fishes.previous_position[swims]
    speed = np.linalg.norm(way, axis=1) / TICK_S
    for k in np.flatnonzero(speed > MAX_BL_S * fishes.length[swims] + MAX_DRIFT_CM_S):
        yield f"fish {swims[k]} moves at {speed[k]:.0f} cm/s"
    if (speed := float(np.linalg.norm(submarine.velocity))) > 2.0 * AHEAD_CM_S:
        yield f"the submarine moves at {speed:.0f} cm/s"
    if abs(submarine.angles[1]) > MAX_PITCH + SLACK:
        yield f"the submarine's pitch is {np.degrees(submarine.angles[1]):.0f} degrees"


def in_water(world: World) -> NDArray[np.intp]:
    """Living fishes, except one that a hook pulls out of the water."""
    swims = world.state.fishes.alive.copy()
    if (caught := int(world.state.sea.catch[1])) >= 0:
        swims[caught] = False
    return np.flatnonzero(swims)


def starving(world: World) -> int:
    """Number of living fishes of maximum hunger."""
    return int((world.state.fishes.alive & (world.state.minds.mental[:, HUNGER] >= 1.0)).sum())


def out_of_sea(places: Array, sea: Sea) -> NDArray[np.bool_]:
    """Flags of places (n, 3) beyond the bounds, in the air or in the ground."""
    floor = [height_at(sea.heights, sea.half_width, float(x), float(y)) for x, y, _ in places]
    beyond = np.hypot(places[:, 0], places[:, 1]) > sea.radius * (1.0 + SLACK)
    return np.asarray(beyond | (places[:, 2] <= floor) | (places[:, 2] >= 0.0))


def depth_in_rock(places: Array, sea: Sea) -> Array:
    """Depth of places (n, 3) inside pillars and rocks (n,), cm; 0 outside."""
    return np.maximum(-clearances(sea.pillars, sea.rocks, places), 0.0)


class VisitedBoxes(NamedTuple):
    """The bounding box of each fish's positions."""

    low: Array  # (n, 3), cm
    high: Array  # (n, 3), cm


def visited_now(world: World) -> VisitedBoxes:
    """Boxes of the current positions only."""
    return VisitedBoxes(world.state.fishes.position.copy(), world.state.fishes.position.copy())


def widen(boxes: VisitedBoxes, world: World) -> None:
    """Extend the boxes to the current positions."""
    np.minimum(boxes.low, world.state.fishes.position, out=boxes.low)
    np.maximum(boxes.high, world.state.fishes.position, out=boxes.high)


def stuck(boxes: VisitedBoxes, world: World) -> list[int]:
    """The living fishes that have not moved."""
    side = np.linalg.norm(boxes.high - boxes.low, axis=1)
    swims = in_water(world)
    return [int(i) for i in swims if side[i] < STILL_BL * world.state.fishes.length[i]]


def _words(place: Array) -> str:
    return ", ".join(f"{x:.0f}" for x in place)
