"""Levels of motion and mind: fishes far from the submarine act less often (SMC table 1).

In a dive, a fish that acts in a tick feels the water and commands its motion for all ticks until it
acts again. Every fish eases its goal and plays its motion in every tick, so none moves in steps,
whichever camera looks at it. Levels depend on the state of the world alone: on the tick, and on the
number, the place and the intention of a fish.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Bools, Ints
from subsea.geometry.vector import dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.perception.senses import FAR_TICKS, NEAR_CM, UNSEEN_TICKS
from subsea.state import CIRCLING, ESCAPE, RUSHING, Clock, Fishes, Minds, Sea, State

# Ticks for which a fish acts at once, by its distance. A change of speed at the next act, seen from
# the submarine, is no larger than that of a fish at 200 cm in a tick.
LEVELS = ((1600.0, 8), (800.0, 4), (400.0, 2))
# Ticks between two thoughts. Those of fishes that act less often are in ticks in which they act.
THOUGHTS = ((800.0, 8), (400.0, 4), (200.0, 2))
RUSH_BL = 3.0  # distance from a rushing hunter, over its length, within which all act
LEAST_PART = 8192  # fishes for which another thread pays


class Turns(NamedTuple):
    """The fishes whose turn it is in a tick, rising."""

    thinking: Ints
    feeling: Ints  # the water, and each other: all that act
    acting: tuple[tuple[Clock, Ints], ...]  # by the time for which they act


def find_turns(state: State, visibility: float, awake: Ints, clock: Clock) -> Turns:
    """Find the fishes that think and act in this tick; add a tick to `minds.pause` of all.

    Fishes of `awake` act in every tick.
    """
    fishes, minds = state.fishes, state.minds
    everyone = np.arange(len(fishes.species))
    busy = np.zeros(len(everyone), np.bool_)
    hunters = np.flatnonzero((minds.hunt == RUSHING) & fishes.alive)
    prey = minds.target[hunters]
    busy[prey[(prey >= 0) & (prey < len(busy))]] = True  # not the bait
    busy[awake] = True
    thinks, acts = np.empty(len(everyone), np.bool_), np.empty(len(everyone), np.int64)
    groups = fishes, minds, state.sea, hunters, busy, visibility, clock
    share(take_turns, everyone, LEAST_PART, *groups, (thinks, acts))
    ticks = sorted({1, *(number for _, number in LEVELS)})
    acting = [(clock._replace(dt=one * clock.dt), np.flatnonzero(acts == one)) for one in ticks]
    parts = tuple(part for part in acting if len(part[1]))
    return Turns(np.flatnonzero(thinks), np.flatnonzero(acts), parts)


@kernel
def take_turns(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, hunters: Ints, busy: Bools,
    visibility: float, clock: Clock, out: tuple[Bools, Ints],
) -> None:  # fmt: skip
    """Write whether each of the fishes `who` thinks now, and for how many ticks it acts now.

    That number is 0 for a fish that does not act. Turns are spread evenly over ticks. In the first
    tick all think and act. Fishes act in every tick that are simulated, are `busy` (n,), flee, hunt
    in a rush or are near one of the `hunters` that do, and pairs that circle or do what follows.
    """
    thinks, acts = out
    there = vector(sea.submarine)
    for i in who:
        minds.pause[i] += np.float32(clock.dt)
        thinks[i], acts[i] = False, 0
        if not fishes.alive[i]:
            continue
        distance = norm(minus(vector(fishes.position[i]), there))
        courts = minds.courtship[i] >= CIRCLING
        whole = courts or busy[i] or fishes.live[i] or minds.intention[i] == ESCAPE
        whole = whole or _is_in_rush(fishes, i, hunters)
        level = 1 if whole else _ticks(LEVELS, distance)
        if courts:
            thought = 1
        elif distance >= visibility:
            thought = UNSEEN_TICKS
        elif whole:
            thought = FAR_TICKS if distance >= NEAR_CM else 1
        else:
            thought = _ticks(THOUGHTS, distance)
        turn = clock.tick + i
        thinks[i] = clock.tick == 0 or turn % thought == 0
        if clock.tick == 0:
            acts[i] = 1
        elif turn % level == 0:
            acts[i] = level


@kernel
def _ticks(levels: tuple[tuple[float, int], ...], distance: float) -> int:
    """The number of ticks for a distance, cm."""
    for least, ticks in levels:
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
