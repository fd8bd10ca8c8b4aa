"""Table of behaviors: a row for each, and the entries that call all of them."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior import (
    avoiding,
    curious,
    eating,
    escaping,
    leaving,
    mating,
    schooling,
    struggling,
    wandering,
)
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.state import Clock, Fishes, Minds, Nature, Sea

# Writes the strength of a desire of each of the fishes `who`, 0 to 1, into `out` (n,).
Desire = Callable[[Ints, Fishes, Minds, Sea, Nature, Clock, Array], None]
# Sets urge, goal speed and gape of each of the fishes `who`.
Routine = Callable[[Ints, Fishes, Minds, Sea, Nature, Clock], None]

# Levels of the hierarchy (Tu §7.5): a desire on one comes before all desires on the next.
COLLISION, DANGER, APPETITE, EASE = range(4)
LEAST_PART = 1024  # fishes of an intention for which another thread pays


class Behavior(NamedTuple):
    """An intention: its routine, and the desires that lead to it with their levels."""

    name: str
    routine: Routine
    desires: tuple[tuple[int, Desire], ...]
    tires: bool = False  # True if the desire fades while it is followed (Tu §7.7.2)
    in_turn: bool = False  # True if the routine reads what it writes for others: no parts


# The first seven in the order of the codes AVOID to WANDER of `state`.
BEHAVIORS = (
    Behavior("avoid", avoiding.act, ((COLLISION, avoiding.desire),), in_turn=True),
    Behavior("escape", escaping.act, ((DANGER, escaping.desire),)),
    Behavior(
        "school",
        schooling.act,
        ((DANGER, schooling.alarmed_desire), (EASE, schooling.desire)),
    ),
    Behavior("eat", eating.act, ((APPETITE, eating.desire),), tires=True),
    Behavior("mate", mating.act, ((APPETITE, mating.desire),), tires=True, in_turn=True),
    Behavior("leave", leaving.act, ((EASE, leaving.desire),)),
    Behavior("wander", wandering.act, ((EASE, wandering.desire),)),
    Behavior("curious", curious.act, ((EASE, curious.desire),), tires=True),
    Behavior("struggle", struggling.act, ((COLLISION, struggling.desire),)),
)
INTENTIONS = tuple(behavior.name for behavior in BEHAVIORS)

# Every desire as (level, behavior, function), most urgent first.
DESIRES = sorted(
    (
        (level, code, desire)
        for code, behavior in enumerate(BEHAVIORS)
        for level, desire in behavior.desires
    ),
    key=lambda row: row[:2],
)
LEVEL_OF_DESIRE = np.array([level for level, _, _ in DESIRES])
BEHAVIOR_OF_DESIRE = np.array([code for _, code, _ in DESIRES])
TIRES = np.array([behavior.tires for behavior in BEHAVIORS])


@kernel
def compute_desires(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Fill `minds.desire` of the fishes `who`: a line for each row of `DESIRES`, in that order."""
    out = minds.desire
    avoiding.desire(who, fishes, minds, sea, nature, clock, out[0])
    struggling.desire(who, fishes, minds, sea, nature, clock, out[1])
    escaping.desire(who, fishes, minds, sea, nature, clock, out[2])
    schooling.alarmed_desire(who, fishes, minds, sea, nature, clock, out[3])
    eating.desire(who, fishes, minds, sea, nature, clock, out[4])
    mating.desire(who, fishes, minds, sea, nature, clock, out[5])
    schooling.desire(who, fishes, minds, sea, nature, clock, out[6])
    leaving.desire(who, fishes, minds, sea, nature, clock, out[7])
    wandering.desire(who, fishes, minds, sea, nature, clock, out[8])
    curious.desire(who, fishes, minds, sea, nature, clock, out[9])


@kernel
def run_routine(
    code: int, who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Let the fishes `who` follow intention `code`: a branch for each row of `BEHAVIORS`."""
    if code == 0:
        avoiding.act(who, fishes, minds, sea, nature, clock)
    elif code == 1:
        escaping.act(who, fishes, minds, sea, nature, clock)
    elif code == 2:
        schooling.act(who, fishes, minds, sea, nature, clock)
    elif code == 3:
        eating.act(who, fishes, minds, sea, nature, clock)
    elif code == 4:
        mating.act(who, fishes, minds, sea, nature, clock)
    elif code == 5:
        leaving.act(who, fishes, minds, sea, nature, clock)
    elif code == 6:
        wandering.act(who, fishes, minds, sea, nature, clock)
    elif code == 7:
        curious.act(who, fishes, minds, sea, nature, clock)
    elif code == 8:
        struggling.act(who, fishes, minds, sea, nature, clock)


def run_routines(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Let each of the fishes `who` follow its intention, one intention after the other."""
    now = minds.intention[who]
    for code in np.flatnonzero(np.bincount(now)):
        follow = partial(_follow, int(code), nature, clock)
        if BEHAVIORS[code].in_turn:
            follow(who[now == code], fishes, minds, sea)
        else:
            share(follow, who[now == code], LEAST_PART, fishes, minds, sea)


def _follow(
    code: int, nature: Nature, clock: Clock, who: Ints, fishes: Fishes, minds: Minds, sea: Sea
) -> None:
    run_routine(code, who, fishes, minds, sea, nature, clock)
