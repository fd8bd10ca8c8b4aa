"""The target of a fish's intention as a text, and its last minute for plots (Tu fig. 9.4)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.behavior.company import disliked, missed
from subsea.behavior.table import INTENTIONS
from subsea.geometry.periodic import shortest
from subsea.state import (
    ANEMONE,
    AVOID,
    BAIT,
    BATHE,
    CLEAN,
    CURIOUS,
    EAT,
    ESCAPE,
    GRAZE,
    GUARD,
    LEAVE,
    MATE,
    MENTAL_STATES,
    NOBODY,
    PICK,
    POLYPS,
    POSE,
    PREDATOR,
    RUBBLE,
    SCHOOL,
    SEABED,
    SHELTER,
    SPONGES,
    SUBMARINE,
    SURFACE,
    TURF,
    WALL,
    WANDER,
    YIELD,
)
from subsea.world.world import TICK_S, World

FOOD = {TURF: "turf", POLYPS: "coral polyps", SPONGES: "a sponge", RUBBLE: "prey in rubble"}
STRUGGLE = INTENTIONS.index("struggle")
SHUN, STAY = INTENTIONS.index("shun"), INTENTIONS.index("stay")
VIGILANT = INTENTIONS.index("watch"), INTENTIONS.index("inspect")
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
    if intention == ESCAPE or intention in VIGILANT:
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
    if intention == PICK:
        return "a speck of plankton", None
    if intention == MATE:
        partner = int(minds.partner[fish])
        return _somebody(world, fish, target if partner == NOBODY else partner)
    if intention == LEAVE:
        return "light or temperature that it dislikes", None
    if intention == WANDER:
        return "a place to swim to", _far(world, fish, minds.waypoint[fish])
    if intention == GRAZE and minds.site[fish] >= 0:
        food = FOOD[int(sea.site_kind[minds.site[fish]])]
        return food, _far(world, fish, sea.site_place[minds.site[fish]])
    if intention in (BATHE, SHELTER) and minds.cover[fish] >= 0:
        own = int(sea.site_kind[minds.cover[fish]]) == ANEMONE
        place = sea.site_place[minds.cover[fish]]
        return "its anemone" if own else "a hiding place", _far(world, fish, place)
    if intention == POSE:
        return _somebody(world, fish, int(minds.cleaner[fish]))
    if intention == CLEAN and minds.client[fish] == NOBODY:
        return "its station", _far(world, fish, minds.home[fish])
    if intention == CLEAN:
        return _somebody(world, fish, int(minds.client[fish]))
    if intention == GUARD:
        return _somebody(world, fish, int(minds.intruder[fish]))
    if intention == YIELD:
        return _somebody(world, fish, int(minds.chaser[fish]))
    if intention == CURIOUS:
        return _somebody(world, fish, SUBMARINE)
    if intention == STRUGGLE:
        return "the hook", _far(world, fish, sea.hook)
    if intention == SHUN:
        k = int(disliked(world.state.fishes, minds, fish, sea))
        return (NOTHING, None) if k < 0 else _somebody(world, fish, int(minds.liked[fish, k]))
    if intention == STAY:
        return _somebody(world, fish, int(missed(world.state.fishes, minds, fish)))
    return NOTHING, None


def feelings(world: World, fish: int) -> list[str]:
    """Describe what a fish feels for others, the strongest first."""
    minds = world.state.minds
    lines = []
    for k in np.argsort(-np.abs(minds.liking[fish]), kind="stable"):
        other, strength = int(minds.liked[fish, k]), float(minds.liking[fish, k])
        if other != NOBODY:
            name = _somebody(world, fish, other)[0]
            lines.append(f"{'likes' if strength > 0.0 else 'dislikes'} {name} {abs(strength):.0%}")
    return lines


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
    fishes = world.state.fishes
    return float(np.linalg.norm(shortest(fishes.position[fish] - place, fishes.period)))


SPAN = round(60.0 / TICK_S)  # ticks
GAP = 40  # ticks: a longer gap clears the chart


class Chart:
    """A value of each mental state of one fish for every tick of the last minute.

    A ring buffer, stored twice so that the last minute is always contiguous.
    """

    def __init__(self, fish: int) -> None:
        """Start empty."""
        self.fish = fish
        self._values = np.zeros((len(MENTAL_STATES), 2 * SPAN), np.float32)
        self._tick, self._ticks = 0, 0  # the last known tick, and the number of known ticks

    def follow(self, world: World) -> None:
        """Add the current values, also for the ticks since the last call.

        Values after a rewind are dropped, and all after a long gap.
        """
        tick, mental = world.state.tick, world.state.minds.mental[self.fish]
        new = tick - self._tick
        if not self._ticks or not -self._ticks < new <= GAP:
            self._ticks, new = 0, 1
        for at in range(tick - max(new, 1) + 1, tick + 1):
            self._values[:, at % SPAN] = self._values[:, at % SPAN + SPAN] = mental
        self._tick, self._ticks = tick, min(self._ticks + new, SPAN)

    @property
    def values(self) -> NDArray[np.floating[Any]]:
        """(3, k) float32, rows as `MENTAL_STATES`, the last column is now: no copy."""
        end = self._tick % SPAN + SPAN + 1
        return self._values[:, end - self._ticks : end]
