"""What must hold of a world after every tick, and what must not last for minutes."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array
from subsea.core.errors import UserError
from subsea.geometry.height_field import height_at
from subsea.state import HUNGER, Sea
from subsea.submarine.hull import AHEAD_CM_S, MAX_PITCH
from subsea.world import snapshot
from subsea.world.world import TICK_S, World

INSIDE_BL = 0.25  # so deep in stone may no fish's middle be, of its length
SWIFT_BL_S, SWIFT_CM_S = 12.0, 150.0  # so fast is no fish: of its length, and carried by water
OFF_UNIT = 1e-3  # a turn's length differs from 1 by less
STILL_BL = 0.5  # who stays in so small a box, of its length, does not move
SHARES = (
    "fishes.weight", "fishes.gape", "fishes.display", "minds.mental", "minds.light",
    "minds.menace", "minds.menaces",
)  # fmt: skip
TURNS = ("fishes.orientation", "fishes.previous_orientation")
SLACK = 1e-5  # of what is rounded


def faults_in(world: World) -> list[str]:
    """What is wrong with a world: numbers that no tick writes, bodies where none can be."""
    try:
        snapshot.check(world)
    except UserError as fault:
        return [str(fault)]
    return [*_odd_numbers(world), *_misplaced(world), *_too_fast(world)]


def _odd_numbers(world: World) -> Iterator[str]:
    """Shares beyond 0 and 1, turns that stretch."""
    arrays = snapshot.changing(world)
    for name in SHARES:
        for where in np.argwhere((arrays[name] < -SLACK) | (arrays[name] > 1.0 + SLACK))[:1]:
            k = tuple(int(index) for index in where)
            yield f"{name}{[*k]} is {arrays[name][k]:g}, expected a share"
    for name in TURNS:
        length = np.linalg.norm(arrays[name], axis=1)
        for k in np.flatnonzero(np.abs(length - 1.0) > OFF_UNIT)[:1]:
            yield f"{name}[{k}] is a turn of length {length[k]:g}"


def _misplaced(world: World) -> Iterator[str]:
    """Fishes, the submarine, specks and leaves out of the sea, or in stone."""
    sea, fishes, submarine = world.state.sea, world.state.fishes, world.state.submarine
    swims = in_water(world)
    names = [*(f"fish {i}" for i in swims), "the submarine"]
    places = np.concatenate([fishes.position[swims], submarine.position[None]])
    allowed = np.append(INSIDE_BL * fishes.length[swims], 0.0)
    out, deep = out_of_sea(places, sea), depth_in_stone(places, sea)
    for k in np.flatnonzero(out):
        yield f"{names[k]} is out of the sea, at {_words(places[k])}"
    for k in np.flatnonzero(deep > allowed):
        yield f"{names[k]} is {deep[k]:.0f} cm deep in stone, at {_words(places[k])}"
    there = sea.plankton[sea.absent == 0.0]
    for k in np.flatnonzero(out_of_sea(there, sea))[:1]:
        yield f"a speck of plankton is out of the sea, at {_words(there[k])}"


def _too_fast(world: World) -> Iterator[str]:
    """What no muscle and no propeller does."""
    fishes, submarine = world.state.fishes, world.state.submarine
    swims = in_water(world)
    way = fishes.position[swims] - fishes.previous_position[swims]
    speed = np.linalg.norm(way, axis=1) / TICK_S
    for k in np.flatnonzero(speed > SWIFT_BL_S * fishes.length[swims] + SWIFT_CM_S):
        yield f"fish {swims[k]} moves at {speed[k]:.0f} cm/s"
    if (speed := float(np.linalg.norm(submarine.velocity))) > 2.0 * AHEAD_CM_S:
        yield f"the submarine moves at {speed:.0f} cm/s"
    if abs(submarine.angles[1]) > MAX_PITCH + SLACK:
        yield f"the submarine's pitch is {np.degrees(submarine.angles[1]):.0f} degrees"


def in_water(world: World) -> NDArray[np.intp]:
    """The fishes that live, but for one that a hook draws up into the air."""
    swims = world.state.fishes.alive.copy()
    if (caught := int(world.state.sea.catch[1])) >= 0:
        swims[caught] = False
    return np.flatnonzero(swims)


def starving(world: World) -> int:
    """How many living fishes are as hungry as can be."""
    return int((world.state.fishes.alive & (world.state.minds.mental[:, HUNGER] >= 1.0)).sum())


def out_of_sea(places: Array, sea: Sea) -> NDArray[np.bool_]:
    """Which of some places (n, 3) are beyond the bounds, in the air or in the ground."""
    floor = [height_at(sea.heights, sea.half_width, float(x), float(y)) for x, y, _ in places]
    beyond = np.hypot(places[:, 0], places[:, 1]) > sea.radius * (1.0 + SLACK)
    return np.asarray(beyond | (places[:, 2] <= floor) | (places[:, 2] >= 0.0))


def depth_in_stone(places: Array, sea: Sea) -> Array:
    """How deep places (n, 3) are in pillars and rocks at least, (n,) cm; 0 outside."""
    deep = np.zeros(len(places))
    for x, y, radius, top in sea.pillars:
        side = radius - np.hypot(places[:, 0] - x, places[:, 1] - y)
        deep = np.maximum(deep, np.minimum(side, top - places[:, 2]))
    for x, y, z, a, b, c, yaw in sea.rocks:
        east, north, up = (places - (x, y, z)).T
        along = np.cos(yaw) * east + np.sin(yaw) * north
        across = np.cos(yaw) * north - np.sin(yaw) * east
        scaled = np.sqrt((along / a) ** 2 + (across / b) ** 2 + (up / c) ** 2)
        deep = np.maximum(deep, (1.0 - scaled) * min(a, b, c))
    return deep


class Reach(NamedTuple):
    """The box in which each fish has been."""

    low: Array  # (n, 3), cm
    high: Array  # (n, 3)


def reach_now(world: World) -> Reach:
    """Boxes that hold nothing but where fishes are now."""
    return Reach(world.state.fishes.position.copy(), world.state.fishes.position.copy())


def widen(reach: Reach, world: World) -> None:
    """Let the boxes hold where fishes are now, too."""
    np.minimum(reach.low, world.state.fishes.position, out=reach.low)
    np.maximum(reach.high, world.state.fishes.position, out=reach.high)


def stuck(reach: Reach, world: World) -> list[int]:
    """The living fishes that have stayed where they were."""
    side = np.linalg.norm(reach.high - reach.low, axis=1)
    swims = in_water(world)
    return [int(i) for i in swims if side[i] < STILL_BL * world.state.fishes.length[i]]


def _words(place: Array) -> str:
    return ", ".join(f"{x:.0f}" for x in place)
