"""A dive that goes on where it is, in another world: where things stand otherwise."""

from collections.abc import Iterator, Sequence

import numpy as np

from subsea.geometry.vector import vector
from subsea.habitat.clearance import clearance, out_of_solids
from subsea.scenario.schema import Shoal
from subsea.state import NOBODY, TRAITS
from subsea.world.populate import ROOM_BL
from subsea.world.snapshot import changing, constant
from subsea.world.tunables import constants_of, put_back
from subsea.world.world import World

LIVING = (
    "fishes.",
    "minds.",
    "directions.",
    "live.",
    "sea.plankton",
    "sea.absent",
    "sea.hook",
    "sea.catch",
)
"""How the names begin of what goes on, in the arrays of `snapshot`."""

INHABITANTS = ("fish", "individual", "hook", "direction")  # of a scenario

CLEAR_CM = 40.0  # of the seabed and the surface, for fishes that are moved out of a solid


def carry(before: World, world: World) -> None:
    """Have a new world go on from a moment of the one before.

    The submarine stays where it is. So do fishes, with all that they have in mind, plankton and
    time, if the same live in both: who is inside a solid then is moved out of it. In any case what
    panels have changed stays changed.
    """
    for name, array in vars(before.state.submarine).items():
        getattr(world.state.submarine, name)[...] = array
    if not _alike(before, world):
        _keep_changes(before, world)
        return
    put_back(world, constants_of(before))
    theirs = {**changing(before), **constant(before)}
    for name, array in {**changing(world), **constant(world)}.items():
        if name.startswith("live."):  # there may be more slots than before
            array[: len(theirs[name])] = theirs[name]
        elif name.startswith(LIVING):
            array[...] = theirs[name]
    world.state.tick = before.state.tick
    world.state.minds.barrier[:] = NOBODY  # solids may have other numbers now
    fishes, sea = world.state.fishes, world.state.sea
    for i, place in enumerate(fishes.position.astype(np.float64)):
        here = vector(place)
        if clearance(sea.pillars, sea.rocks, here) < 0.0:
            room = ROOM_BL * float(fishes.length[i])
            fishes.position[i] = out_of_solids(sea, here, room, CLEAR_CM, CLEAR_CM)
            fishes.previous_position[i] = fishes.position[i]


def _keep_changes(before: World, world: World) -> None:
    """Keep what panels have changed, in single fishes as far as these are there again."""
    world.nature, world.physics = before.nature, before.physics
    world.current_cm_s = before.current_cm_s
    minds = world.state.minds
    fed = minds.eaten / minds.appetite
    for old, new in _same_fishes(before.scenario.fish, world.scenario.fish):
        for name in TRAITS:
            was, now = before.initial_traits[name][old], getattr(before.state.minds, name)[old]
            np.copyto(getattr(minds, name)[new], now, where=now != was)
    minds.eaten[:] = fed * minds.appetite  # as hungry as they began


def _same_fishes(old: Sequence[Shoal], new: Sequence[Shoal]) -> Iterator[tuple[slice, slice]]:
    """Which fishes of some shoals are which of others, of which some are gone or new."""
    both = min(len(old), len(new))
    first = next((k for k in range(both) if old[k] != new[k]), both)
    for k in range(both):
        # Where one of a list is gone, or new, those behind it are in other places.
        i, j = (k, k) if k < first else (k + len(old) - both, k + len(new) - both)
        many = min(old[i].number, new[j].number)
        if old[i].species == new[j].species:
            begins = sum(one.number for one in old[:i]), sum(one.number for one in new[:j])
            yield slice(begins[0], begins[0] + many), slice(begins[1], begins[1] + many)


def _alike(before: World, world: World) -> bool:
    """Whether the same live in both: their sizes, which the dice decided, may differ.

    More of them may be simulated in the new one, but not fewer.
    """
    ours, theirs = changing(world), changing(before)
    return (
        before.state.seed == world.state.seed
        and all(
            getattr(before.scenario, key) == getattr(world.scenario, key) for key in INHABITANTS
        )
        and len(world.state.live.fish) >= len(before.state.live.fish)
        and ours["sea.plankton"].shape == theirs["sea.plankton"].shape
    )
