"""Continue a dive in another world, after the visitor has moved things."""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from subsea.base.arrays import Array
from subsea.geometry.periodic import gathered
from subsea.geometry.solids import height_at
from subsea.geometry.vector import vector
from subsea.habitat.contact import clearance, out_of_solids
from subsea.scenario.schema import Shoal
from subsea.state import NOBODY, TRAITS
from subsea.world.periodic import wrap
from subsea.world.placement import Place
from subsea.world.populate import ROOM_BL
from subsea.world.snapshot import changing, constant
from subsea.world.to_scenario import get_tunables, set_tunables
from subsea.world.world import World

# Prefixes of the arrays that continue, by their names in a snapshot.
LIVING = (
    "fishes.", "minds.", "directions.", "live.",
    "sea.plankton", "sea.absent", "sea.deflection", "sea.hook", "sea.catch", "odour.amount",
    "odour.total",
)  # fmt: skip
INHABITANTS = (
    "individual",
    "hook",
    "direction",
    "school",
)  # tables of a scenario, besides its shoals

CLEAR_CM = 40.0  # distance of fishes from seabed and surface when moved out of a solid


def migrate(before: World, world: World) -> None:
    """Continue the dive of the world `before` in a new `world`.

    The submarine stays. With the same inhabitants, seed and plankton, fishes and directions
    continue; a school that was moved goes on at its new place, and fishes inside a solid are moved
    out of it. Changes by panels persist.
    """
    for name, array in vars(before.state.submarine).items():
        getattr(world.state.submarine, name)[...] = array
    if not _same_inhabitants(before, world):
        _keep_changes(before, world)
        return
    set_tunables(world, get_tunables(before))
    homes = world.state.minds.home.copy()
    theirs = {**changing(before), **constant(before)}
    for name, array in {**changing(world), **constant(world)}.items():
        if name.startswith("live."):  # there may be more slots than before
            array[: len(theirs[name])] = theirs[name]
        elif name == "fishes.period":
            continue  # that of the new sea
        elif name.startswith(LIVING) and array.shape == theirs[name].shape:
            array[...] = theirs[name]
    world.state.tick = before.state.tick
    for name in ("barrier", "site", "cover"):  # solids and sites may have other numbers now
        getattr(world.state.minds, name)[:] = NOBODY
    fishes, sea = world.state.fishes, world.state.sea
    for school, place in _moved_schools(before.scenario.fish, world.scenario.fish):
        _move_school(world, school, np.array(place))
        world.state.minds.home[school] = homes[school]
    for i, place in enumerate(fishes.position.astype(np.float64)):
        here = vector(place)
        if clearance(sea.pillars, sea.rocks, here) < 0.0:
            room = ROOM_BL * float(fishes.length[i])
            fishes.position[i] = out_of_solids(sea, here, room, CLEAR_CM, CLEAR_CM)
            fishes.previous_position[i] = fishes.position[i]
    wrap(fishes, world.state.minds)


def _moved_schools(old: Sequence[Shoal], new: Sequence[Shoal]) -> Iterator[tuple[slice, Place]]:
    """Find the fishes of each shoal with a new place, and that place."""
    begin = 0
    for before, after in zip(old, new, strict=True):
        if after.position_cm is not None and after.position_cm != before.position_cm:
            yield slice(begin, begin + after.number), after.position_cm
        begin += after.number


def _move_school(world: World, school: slice, place: Array) -> None:
    """Move the middle of a school to a place, cm, and its fishes with it, within the sea."""
    fishes, sea = world.state.fishes, world.state.sea
    if not fishes.alive[school].any():
        return
    here = fishes.position[school].astype(np.float64)
    around = gathered(here[fishes.alive[school]], fishes.period)
    there = here + place - around.mean(axis=0)
    away = np.maximum(np.hypot(there[:, 0], there[:, 1]), 1e-6)
    there[:, :2] *= np.minimum(1.0, (sea.radius - CLEAR_CM) / away)[:, None]
    for k, (x, y, z) in enumerate(there):
        low = height_at(sea.floor, sea.half_width, x, y) + CLEAR_CM
        there[k, 2] = min(max(z, low), -CLEAR_CM)
    fishes.position[school] = fishes.previous_position[school] = there
    for seen in (world.state.minds.leader_place, world.state.minds.waypoint):
        seen[school] += (there - here).astype(seen.dtype)


def _keep_changes(before: World, world: World) -> None:
    """Preserve changes by panels, of a fish if it exists in both worlds."""
    world.nature, world.physics = before.nature, before.physics
    world.current_cm_s = before.current_cm_s
    minds = world.state.minds
    fed = minds.eaten / minds.appetite
    for old, new in _same_fishes(before.scenario.fish, world.scenario.fish):
        for name in TRAITS:
            was, value = before.initial_traits[name][old], getattr(before.state.minds, name)[old]
            np.copyto(getattr(minds, name)[new], value, where=value != was)
    minds.eaten[:] = fed * minds.appetite  # keeps their hunger


def _same_fishes(old: Sequence[Shoal], new: Sequence[Shoal]) -> Iterator[tuple[slice, slice]]:
    """Match the fishes of old and new shoals, as pairs of slices of equal length."""
    both = min(len(old), len(new))
    first = next((k for k in range(both) if old[k] != new[k]), both)
    for k in range(both):
        # Behind an inserted or removed shoal, indices are shifted.
        i, j = (k, k) if k < first else (k + len(old) - both, k + len(new) - both)
        many = min(old[i].number, new[j].number)
        if old[i].species == new[j].species:
            begins = sum(shoal.number for shoal in old[:i]), sum(shoal.number for shoal in new[:j])
            yield slice(begins[0], begins[0] + many), slice(begins[1], begins[1] + many)


def _same_inhabitants(before: World, world: World) -> bool:
    """True if both have the same inhabitants, wherever they begin; random sizes may differ.

    The new world may have more slots for simulated fishes, but not fewer.
    """
    ours, theirs = changing(world), changing(before)
    theirs_then, ours_now = (
        [replace(shoal, position_cm=None) for shoal in scenario.fish]
        for scenario in (before.scenario, world.scenario)
    )
    return (
        before.state.seed == world.state.seed
        and theirs_then == ours_now
        and all(
            getattr(before.scenario, key) == getattr(world.scenario, key) for key in INHABITANTS
        )
        and len(world.state.live.fish) >= len(before.state.live.fish)
        and ours["sea.plankton"].shape == theirs["sea.plankton"].shape
    )
