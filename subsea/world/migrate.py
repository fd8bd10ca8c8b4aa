"""Continue a dive in another world, after the visitor has moved things."""

from collections.abc import Iterator, Sequence

import numpy as np

from subsea.geometry.vector import vector
from subsea.habitat.clearance import clearance, out_of_solids
from subsea.scenario.schema import Shoal
from subsea.state import NOBODY, TRAITS
from subsea.world.populate import ROOM_BL
from subsea.world.snapshot import changing, constant
from subsea.world.tunables import get_tunables, set_tunables
from subsea.world.world import World

# Prefixes of the arrays that continue, by their names in a snapshot.
LIVING = (
    "fishes.", "minds.", "directions.", "live.",
    "sea.plankton", "sea.absent", "sea.hook", "sea.catch",
)  # fmt: skip
INHABITANTS = ("fish", "individual", "hook", "direction")  # tables of a scenario

CLEAR_CM = 40.0  # distance of fishes from seabed and surface when moved out of a solid


def migrate(before: World, world: World) -> None:
    """Continue the dive of the world `before` in a new `world`.

    The submarine stays. With the same inhabitants, seed and plankton, fishes and directions
    continue, and fishes inside a solid are moved out of it. Changes by panels persist.
    """
    for name, array in vars(before.state.submarine).items():
        getattr(world.state.submarine, name)[...] = array
    if not _same_inhabitants(before, world):
        _keep_changes(before, world)
        return
    set_tunables(world, get_tunables(before))
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
    """Preserve changes by panels; those of single fishes where the fish exists in both worlds."""
    world.nature, world.physics = before.nature, before.physics
    world.current_cm_s = before.current_cm_s
    minds = world.state.minds
    fed = minds.eaten / minds.appetite
    for old, new in _same_fishes(before.scenario.fish, world.scenario.fish):
        for name in TRAITS:
            was, now = before.initial_traits[name][old], getattr(before.state.minds, name)[old]
            np.copyto(getattr(minds, name)[new], now, where=now != was)
    minds.eaten[:] = fed * minds.appetite  # the same hunger


def _same_fishes(old: Sequence[Shoal], new: Sequence[Shoal]) -> Iterator[tuple[slice, slice]]:
    """Match fishes of old and new shoals: pairs of equal slices."""
    both = min(len(old), len(new))
    first = next((k for k in range(both) if old[k] != new[k]), both)
    for k in range(both):
        # Behind an inserted or removed shoal, indices are shifted.
        i, j = (k, k) if k < first else (k + len(old) - both, k + len(new) - both)
        many = min(old[i].number, new[j].number)
        if old[i].species == new[j].species:
            begins = sum(one.number for one in old[:i]), sum(one.number for one in new[:j])
            yield slice(begins[0], begins[0] + many), slice(begins[1], begins[1] + many)


def _same_inhabitants(before: World, world: World) -> bool:
    """True if both have the same inhabitants; their random sizes may differ.

    The new world may have more slots for simulated fishes, but not fewer.
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
