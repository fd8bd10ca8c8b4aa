"""Table of behaviors: a row for each, and the entries that call all of them."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

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
from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel
from subsea.state import Clock, Fishes, Minds, Nature, Sea

# Writes the strength of a desire of each of the fishes `who`, 0 to 1, into `out` (n,).
Desire = Callable[[Ints, Fishes, Minds, Sea, Nature, Clock, Array], None]
# Sets urge, goal speed and gape of each of the fishes `who`.
Routine = Callable[[Ints, Fishes, Minds, Sea, Nature, Clock], None]

# Levels of the hierarchy (Tu §7.5): a desire on one comes before all desires on the next.
COLLISION, DANGER, APPETITE, EASE = range(4)


class Behavior(NamedTuple):
    """An intention: its routine, and the desires that lead to it with their levels."""

    name: str
    routine: Routine
    desires: tuple[tuple[int, Desire], ...]
    tires: bool = False  # True if the desire fades while it is followed (Tu §7.7.2)


# The first seven in the order of the codes AVOID to WANDER of `state`.
BEHAVIORS = (
    Behavior("avoid", avoiding.act, ((COLLISION, avoiding.desire),)),
    Behavior("escape", escaping.act, ((DANGER, escaping.desire),)),
    Behavior(
        "school",
        schooling.act,
        ((DANGER, schooling.alarmed_desire), (EASE, schooling.desire)),
    ),
    Behavior("eat", eating.act, ((APPETITE, eating.desire),), tires=True),
    Behavior("mate", mating.act, ((APPETITE, mating.desire),), tires=True),
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
def run_routines(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Let each of the fishes `who` follow its intention: a line for each row of `BEHAVIORS`."""
    now = minds.intention[who]
    avoiding.act(who[now == 0], fishes, minds, sea, nature, clock)
    escaping.act(who[now == 1], fishes, minds, sea, nature, clock)
    schooling.act(who[now == 2], fishes, minds, sea, nature, clock)
    eating.act(who[now == 3], fishes, minds, sea, nature, clock)
    mating.act(who[now == 4], fishes, minds, sea, nature, clock)
    leaving.act(who[now == 5], fishes, minds, sea, nature, clock)
    wandering.act(who[now == 6], fishes, minds, sea, nature, clock)
    curious.act(who[now == 7], fishes, minds, sea, nature, clock)
    struggling.act(who[now == 8], fishes, minds, sea, nature, clock)
