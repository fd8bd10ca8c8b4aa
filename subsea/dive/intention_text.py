"""The target of a fish's intention, as a text, and its distance."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.behavior.table import INTENTIONS
from subsea.state import (
    AVOID,
    BAIT,
    EAT,
    ESCAPE,
    LEAVE,
    MATE,
    NOBODY,
    PREDATOR,
    SCHOOL,
    SEABED,
    SUBMARINE,
    SURFACE,
    WALL,
    WANDER,
)
from subsea.world.world import World

CURIOUS, STRUGGLE = INTENTIONS.index("curious"), INTENTIONS.index("struggle")
BARRIERS = {SEABED: "the seabed", SURFACE: "the surface", WALL: "the edge of the sea"}
NOTHING = "nothing"

Focus = tuple[str, float | None]  # target, and its distance from the body, cm, if it is a place


def name_of(world: World, fish: int) -> str:
    """Species and number of a fish."""
    return f"{world.species[world.state.fishes.species[fish]].name} {fish}"


def focus(world: World, fish: int) -> Focus:
    """The current target of a fish: a fish, a thing, or nothing."""
    minds, sea = world.state.minds, world.state.sea
    intention, target = int(minds.intention[fish]), int(minds.target[fish])
    if intention == AVOID:
        if minds.threat[fish] >= 0:
            return _somebody(world, fish, int(minds.threat[fish]))
        return _barrier(world, int(minds.barrier[fish])), None
    if intention == ESCAPE:
        return _somebody(world, fish, int(minds.predator[fish]))
    if intention == SCHOOL:
        if minds.led[fish] and minds.leader[fish] >= 0:
            return _somebody(world, fish, int(minds.leader[fish]))
        if not minds.led[fish]:
            return "its neighbours", None
        return ("those that follow it" if minds.leads[fish] else NOTHING), None
    if intention == EAT and (target == BAIT or minds.kind[fish] != PREDATOR):
        if target == BAIT:
            return "the bait", _far(world, fish, sea.hook)
        if target >= 0:
            return "a speck of plankton", _far(world, fish, sea.plankton[target])
        return NOTHING, None
    if intention == EAT:
        return _somebody(world, fish, target)
    if intention == MATE:
        partner = int(minds.partner[fish])
        return _somebody(world, fish, target if partner == NOBODY else partner)
    if intention == LEAVE:
        return "light or temperature that it dislikes", None
    if intention == WANDER:
        return "a place to swim to", _far(world, fish, minds.waypoint[fish])
    if intention == CURIOUS:
        return _somebody(world, fish, SUBMARINE)
    if intention == STRUGGLE:
        return "the hook", _far(world, fish, sea.hook)
    return NOTHING, None


def _somebody(world: World, fish: int, other: int) -> Focus:
    if other == SUBMARINE:
        return "the submarine", _far(world, fish, world.state.submarine.position)
    if other < 0:
        return NOTHING, None
    return name_of(world, other), _far(world, fish, world.state.fishes.position[other])


def _barrier(world: World, barrier: int) -> str:
    if barrier < 0:
        return BARRIERS.get(barrier, NOTHING)
    pillars = len(world.state.sea.pillars)
    return f"pillar {barrier}" if barrier < pillars else f"rock {barrier - pillars}"


def _far(world: World, fish: int, place: NDArray[np.floating[Any]]) -> float:
    return float(np.linalg.norm(world.state.fishes.position[fish] - place))
