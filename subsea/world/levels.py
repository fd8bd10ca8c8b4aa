"""Levels of mind: in a dive, fishes far from the submarine think and feel less often.

A fish that feels the water in a tick does so for all ticks until its next turn, and keeps its drift
in between. Every fish eases its goal and plays its motion in every tick, so none moves in steps,
whichever camera looks at it. Turns depend on the state of the world alone: on the tick, and on the
number, the place and the intention of a fish.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Bools, Ints
from subsea.geometry.vector import dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.perception.senses import FAR_TICKS, NEAR_CM, UNSEEN_TICKS
from subsea.scenario.schema import Scenario
from subsea.state import CIRCLING, ESCAPE, FEAR, RUSHING, Clock, Fishes, Minds, Sea, State

# Ticks from one turn to the next, by the least distance, cm. A fish thinks only in ticks in which
# it feels the water.
THOUGHTS = ((1600.0, 16), (800.0, 8), (400.0, 4))
FEELINGS = ((1600.0, 8), (800.0, 4), (400.0, 2))
# Distance, cm, from which fins move for FIN_TICKS at once. All numbers of ticks are powers of two.
FINS_CM, FIN_TICKS = 400.0, 4
STRIDE_CM = 8.0  # farthest way between two: a fish brakes before a barrier, without a jerk
RUSH_BL = 3.0  # distance from a rushing hunter, over its length, within which all feel the water
MANY = 500  # fishes; with fewer, a tick is cheap, and a dive shows the world of its film
LEAST_PART = 8192  # fishes for which another thread pays


def has_levels(scenario: Scenario, state: State) -> bool:
    """Tell if a dive in a scenario has levels: in seas of many fishes, unless it says no.

    In a box no place is far from any other.
    """
    many = len(state.fishes.species) >= MANY
    return scenario.levels and many and scenario.bounds.periodic_cm is None


class Turns(NamedTuple):
    """The fishes whose turn it is in a tick, rising."""

    thinking: Ints
    feeling: Ints  # the water, bodies and barriers
    parts: tuple[tuple[Clock, Ints], ...]  # of `feeling`, each with the time until their next turn
    flapping: Bools  # (n,) whether its fins move


def find_turns(state: State, visibility: float, alarmed: float, awake: Ints, clock: Clock) -> Turns:
    """Find the fishes that think, feel and flap in this tick; add a tick to `minds.pause` of all.

    Fishes of `awake` feel the water in every tick. `alarmed` is the fear that alarms a fish.
    """
    fishes, minds = state.fishes, state.minds
    everyone = np.arange(len(fishes.species))
    busy = np.zeros(len(everyone), np.bool_)
    hunters = np.flatnonzero((minds.hunt == RUSHING) & fishes.alive)
    prey = minds.target[hunters]
    busy[prey[(prey >= 0) & (prey < len(busy))]] = True  # not the bait
    busy[awake] = True
    thinks, flaps = np.empty((2, len(everyone)), np.bool_)
    feels = np.empty(len(everyone), np.int64)
    limits = visibility, alarmed
    groups = fishes, minds, state.sea, (hunters, busy), limits, clock, (thinks, feels, flaps)
    share(take_turns, everyone, LEAST_PART, *groups)
    ticks = sorted({1, *(number for _, number in FEELINGS)})
    parts = [(clock._replace(dt=one * clock.dt), np.flatnonzero(feels == one)) for one in ticks]
    those = tuple(part for part in parts if len(part[1]))
    return Turns(np.flatnonzero(thinks), np.flatnonzero(feels), those, flaps)


@kernel
def take_turns(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, active: tuple[Ints, Bools],
    limits: tuple[float, float], clock: Clock, out: tuple[Bools, Ints, Bools],
) -> None:  # fmt: skip
    """Write of the fishes `who` if each thinks now, for how many ticks it feels, and if it flaps.

    That number is 0 for a fish that does not feel. Turns are spread evenly over ticks. In the first
    tick all think and feel. Fishes feel in every tick that are simulated, are `busy` (n,), flee,
    hunt in a rush or are near one of the `hunters` that do, and pairs that circle or do what
    follows. These, and fishes that are alarmed, think as often as without levels. Fast fishes feel
    more often. `active` are these hunters, and whether a fish is busy; `limits` are the visibility,
    cm, and the fear that alarms.
    """
    thinks, feels, flaps = out
    visibility, alarmed = limits
    hunters, busy = active
    there = vector(sea.submarine)
    for i in who:
        minds.pause[i] += np.float32(clock.dt)
        thinks[i], feels[i], flaps[i] = False, 0, False
        if not fishes.alive[i]:
            continue
        distance = norm(minus(vector(fishes.position[i]), there))
        courts = minds.courtship[i] >= CIRCLING
        whole = courts or busy[i] or fishes.live[i] or minds.intention[i] == ESCAPE
        whole = whole or _is_in_rush(fishes, i, hunters)
        thought = _ticks(THOUGHTS, distance)
        if courts:
            thought = 1
        elif whole or minds.mental[i, FEAR] >= alarmed:
            thought = FAR_TICKS if distance >= NEAR_CM else 1
        if distance >= visibility and not courts:
            thought = max(thought, UNSEEN_TICKS)
        feeling = 1 if whole else min(_ticks(FEELINGS, distance), thought)
        stride = norm(vector(fishes.velocity[i])) * clock.dt
        while feeling > 1 and feeling * stride > STRIDE_CM:
            feeling //= 2
        turn = clock.tick + i
        thinks[i] = clock.tick == 0 or turn & (thought - 1) == 0
        if clock.tick == 0:
            feels[i] = 1
        elif turn & (feeling - 1) == 0:
            feels[i] = feeling
        flaps[i] = distance < FINS_CM or turn & (FIN_TICKS - 1) == 0


@kernel
def _ticks(turns: tuple[tuple[float, int], ...], distance: float) -> int:
    """The number of ticks for a distance, cm."""
    for least, ticks in turns:
        if distance >= least:
            return ticks
    return 1


@kernel
def _is_in_rush(fishes: Fishes, i: int, hunters: Ints) -> bool:
    """True for one of the hunters, and for a fish that their mouths may draw in or drive off."""
    here = vector(fishes.position[i])
    for h in hunters:
        gap = minus(vector(fishes.position[h]), here)
        reach = RUSH_BL * float(fishes.length[h])
        if dot(gap, gap) < reach * reach:
            return True
    return False
