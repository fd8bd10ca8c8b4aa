"""List the behaviors in one table, and let fishes follow them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base import registry
from subsea.base.arrays import Bools, Ints
from subsea.base.errors import UserError, nearest
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


class BehaviorTable(NamedTuple):
    """The b behaviors of a world by their codes, and their d desires, most urgent first."""

    behaviors: tuple[Behavior, ...]
    desires: tuple[Desire, ...]
    level: Ints  # (d,) of each desire
    behavior: Ints  # (d,) code of the behavior that each desire leads to
    shared: tuple[tuple[int, Desire], ...]  # rows of `desires` that take any part of the fishes
    whole: tuple[tuple[int, Desire], ...]  # the other rows, which take all fishes in one call
    tires: Bools  # (b,)
    seeks: Bools  # (b,)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the intentions by their codes."""
        return tuple(behavior.name for behavior in self.behaviors)


def make_table(behaviors: Sequence[Behavior]) -> BehaviorTable:
    """Make the table of behaviors whose codes are their places in a list."""
    rows = desires_of(behaviors)
    codes = [code for _, code, _ in rows]
    numbered = [(row, desire) for row, (_, _, desire) in enumerate(rows)]
    whole = [behavior.whole for behavior in behaviors]
    return BehaviorTable(
        behaviors=tuple(behaviors),
        desires=tuple(desire for _, _, desire in rows),
        level=np.array([level for level, _, _ in rows]),
        behavior=np.array(codes),
        shared=tuple(one for one, code in zip(numbered, codes, strict=True) if not whole[code]),
        whole=tuple(one for one, code in zip(numbered, codes, strict=True) if whole[code]),
        tires=np.array([behavior.tires for behavior in behaviors]),
        seeks=np.array([behavior.seeks for behavior in behaviors]),
    )


MAX_BEHAVIORS = 200  # a record holds an intention in a byte


def with_behaviors(given: Sequence[Behavior]) -> BehaviorTable:
    """Make a table with more behaviors; one with the name of another replaces it.

    A behavior without desires keeps those of the one that it replaces. Raises a UserError for a
    name that is given twice, and for a new behavior without desires.
    """
    behaviors = list(BEHAVIORS)
    names = [one.name for one in given]
    for one in given:
        if names.count(one.name) > 1:
            raise UserError(f"behavior {one.name!r} is given twice")
        if one.name in INTENTIONS:
            code = INTENTIONS.index(one.name)
            before = behaviors[code]
            if not one.desires:
                one = one._replace(desires=before.desires, tires=before.tires, seeks=before.seeks)
            behaviors[code] = one
        elif one.desires:
            behaviors.append(one)
        else:
            hint = nearest(one.name, list(INTENTIONS)) or f"; ours are: {', '.join(INTENTIONS)}"
            raise UserError(
                f"behavior {one.name!r} needs a desire, as it replaces none of ours{hint}"
            )
    if len(behaviors) > MAX_BEHAVIORS:
        raise UserError(f"{len(behaviors)} behaviors, expected at most {MAX_BEHAVIORS}")
    return make_table(behaviors)


TABLE = make_table(BEHAVIORS)
"""The table of all worlds that are given no other behaviors."""


def compute_desires(
    who: Ints,
    fishes: Fishes,
    minds: Minds,
    sea: Sea,
    nature: Nature,
    clock: Clock,
    rows: tuple[tuple[int, Desire], ...] = TABLE.shared,
) -> None:
    """Fill rows of `minds.desire` for the fishes `who`; `whole` rows need all of a tick."""
    for row, desire in rows:
        desire(who, fishes, minds, sea, nature, clock, minds.desire[row])


def run_routines(
    who: Ints,
    fishes: Fishes,
    minds: Minds,
    sea: Sea,
    nature: Nature,
    clock: Clock,
    table: BehaviorTable = TABLE,
) -> None:
    """Let each of the fishes `who` follow its intention, one intention after the other.

    A fish that seeks something and lost it wanders for as long as its intention lasts.
    """
    now = minds.intention[who].copy()
    for code in np.flatnonzero(table.seeks):
        seeks = np.flatnonzero(now == code)
        if len(seeks):
            wishes = minds.desire[code == table.behavior][:, who[seeks]]
            now[seeks[(wishes <= 0.0).all(axis=0)]] = WANDER
    for code in np.flatnonzero(np.bincount(now)):
        behavior = table.behaviors[code]
        # Fishes of a routine that reads what it writes for others are one part.
        least = len(who) if behavior.in_turn or behavior.whole else LEAST_PART
        share(behavior.routine, who[now == code], least, fishes, minds, sea, nature, clock)
