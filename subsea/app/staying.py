"""A dive that goes on where it is, in another world: where things stand otherwise."""

import numpy as np

from subsea.constants import constants_of, put_back
from subsea.habitat.solids import clearance, out_of_solids
from subsea.kinematics.vector import vector
from subsea.snapshot import changing, constant
from subsea.state import NOBODY
from subsea.world import ROOM_BL, World

LIVING = ("fishes.", "minds.", "live.", "sea.plankton", "sea.absent", "sea.hook", "sea.catch")
"""How the names begin of what goes on, in the arrays of `snapshot`."""

INHABITANTS = ("fish", "individual", "hook")  # of a scenario

CLEAR_CM = 40.0  # of the seabed and the surface, for fishes that are moved out of a solid


def carry(before: World, world: World) -> None:
    """Have a new world go on from a moment of the one before.

    The submarine stays where it is. So do fishes, with all that they have in mind, plankton and
    time, if the same live in both: who is inside a solid then is moved out of it.
    """
    for name, array in vars(before.state.submarine).items():
        getattr(world.state.submarine, name)[...] = array
    if not _alike(before, world):
        return
    put_back(world, constants_of(before))  # what panels have changed
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
