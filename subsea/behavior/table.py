"""List the behaviors in one table, and let fishes follow them."""

from collections.abc import Sequence

import numpy as np

from subsea.base import registry
from subsea.base.arrays import Ints
from subsea.base.progress import say
from subsea.behavior import (
    avoiding,
    biting,
    cleaning,
    company,
    curious,
    eating,
    escaping,
    grazing,
    inspecting,
    leaving,
    mating,
    picking,
    schooling,
    sheltering,
    territory,
    vigilance,
    wandering,
)
from subsea.behavior.intention import APPETITE, COLLISION, DANGER, EASE, Behavior, Desire
from subsea.kernels.threads import share
from subsea.state import WANDER, Clock, Fishes, Minds, Nature, Sea

LEAST_PART = 1024  # fishes of an intention for which another thread pays

# In the order of the codes AVOID to CURIOUS and GRAZE to CLEAN of `state`.
OURS = (
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
    Behavior("struggle", biting.struggle, ((COLLISION, biting.hooked_desire),)),
    Behavior("graze", grazing.act, ((APPETITE, grazing.desire),), tires=True, seeks=True),
    Behavior("bathe", sheltering.bathe, ((EASE, sheltering.bathing_desire),), seeks=True),
    Behavior(
        "guard",
        territory.act,
        ((APPETITE, territory.desire),),
        tires=True,
        in_turn=True,
        seeks=True,
    ),
    Behavior("yield", territory.give_way, ((DANGER, territory.yielding_desire),), seeks=True),
    Behavior("shelter", sheltering.act, ((DANGER, sheltering.desire),), seeks=True),
    Behavior("pose", cleaning.pose, ((EASE, cleaning.posing_desire),), tires=True, seeks=True),
    Behavior(
        "clean",
        cleaning.act,
        ((APPETITE, cleaning.desire), (EASE, cleaning.holding_desire)),
        in_turn=True,
    ),
    Behavior("shun", company.shun, ((EASE, company.shun_desire),)),
    Behavior("stay", company.stay, ((EASE, company.stay_desire),)),
    Behavior("watch", vigilance.watch, ((EASE, vigilance.watch_desire),)),
    Behavior(
        "inspect",
        inspecting.act,
        ((DANGER, inspecting.undaunted_desire), (EASE, inspecting.desire)),
    ),
    Behavior("pick", picking.act, ((EASE, picking.desire),)),
)


def _registered() -> list[Behavior]:
    """Load the behaviors of other packages, and say which are of another type."""
    behaviors = []
    for name, behavior in registry.load_all(registry.BEHAVIORS):
        if isinstance(behavior, Behavior):
            behaviors.append(behavior._replace(name=name))
        else:
            say(f"{registry.BEHAVIORS}: {name} is not a Behavior of subsea.behavior.intention")
    return behaviors


BEHAVIORS = (*OURS, *_registered())
INTENTIONS = tuple(behavior.name for behavior in BEHAVIORS)


def desires_of(behaviors: Sequence[Behavior]) -> list[tuple[int, int, Desire]]:
    """List every desire as (level, behavior, function), most urgent first."""
    rows = [
        (level, code, desire)
        for code, behavior in enumerate(behaviors)
        for level, desire in behavior.desires
    ]
    return sorted(rows, key=lambda row: row[:2])


DESIRES = desires_of(BEHAVIORS)
LEVEL_OF_DESIRE = np.array([level for level, _, _ in DESIRES])
BEHAVIOR_OF_DESIRE = np.array([code for _, code, _ in DESIRES])
TIRES = np.array([behavior.tires for behavior in BEHAVIORS])
SEEKS = np.array([behavior.seeks for behavior in BEHAVIORS])


def compute_desires(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Fill `minds.desire` of the fishes `who`."""
    for row, (_, _, desire) in enumerate(DESIRES):
        desire(who, fishes, minds, sea, nature, clock, minds.desire[row])


def run_routines(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Let each of the fishes `who` follow its intention, one intention after the other.

    A fish that seeks something and lost it wanders for as long as its intention lasts.
    """
    now = minds.intention[who].copy()
    for code in np.flatnonzero(SEEKS):
        seeks = np.flatnonzero(now == code)
        if len(seeks):
            wishes = minds.desire[code == BEHAVIOR_OF_DESIRE][:, who[seeks]]
            now[seeks[(wishes <= 0.0).all(axis=0)]] = WANDER
    for code in np.flatnonzero(np.bincount(now)):
        behavior = BEHAVIORS[code]
        # Fishes of a routine that reads what it writes for others are one part.
        least = len(who) if behavior.in_turn else LEAST_PART
        share(behavior.routine, who[now == code], least, fishes, minds, sea, nature, clock)
