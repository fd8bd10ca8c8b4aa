"""The intention generator: a hierarchy of desires, with memory, inhibition and fatigue."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.kernels import kernel
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
    in_turn: bool = False  # True if the routine reads what it writes for others: never cut up
    whole: bool = False  # True if desires and routine take all fishes of a tick in one call
    seeks: bool = False  # True if only a desire has an object: a fish that lost its own wanders


# Share of the present desire's strength that its rivals lose: after it was resumed (Tu §7.7.2),
# and otherwise, so that two equal desires that tire do not alternate.
INHIBITION, GRACE = 0.2, 0.05
# Factor on a desire that still recovers, so that a fish rests longer than a moment.
RESTS = 0.8
MEMORY_S = 12.0  # after which an interrupted intention is forgotten
# Least duration of an intention unless a reaction interrupts it. A reaction lasts so long after its
# cause was last perceived, unless another reaction interrupts it.
DWELL_S = 0.5
LASTING = 2  # first level whose intentions are remembered; earlier ones are reactions


@kernel
def choose_intention(
    who: Ints, minds: Minds, nature: Nature, level: Ints, behavior: Ints, tires: Bools
) -> None:
    """Set the intentions of the fishes `who` (Tu fig. 7.4, with the cases 7.9 and 7.12).

    `minds.desire` has a row for each of d desires; `level` and `behavior` (d,) are its level in
    the hierarchy and the behavior it leads to, most urgent first. The strongest desire on the
    first level that has any wins. An intention interrupted by a reaction is remembered with its
    target and resumed once the reaction is over; then it inhibits its rivals (Tu §7.7). A desire
    whose behavior `tires` (b,) fades while it is followed, and recovers afterwards.
    """
    strength = np.empty(len(level), np.float64)
    lasting = np.zeros(len(tires), np.bool_)
    for row in range(len(level)):
        lasting[behavior[row]] |= level[row] >= LASTING
    for i in who:
        now = minds.intention[i]
        for code in range(len(tires)):
            if tires[code]:
                spent = minds.pause[i] if code == now else -minds.pause[i]
                minds.fatigue[code, i] = max(minds.fatigue[code, i] + spent, 0.0)
        for row in range(len(level)):
            strength[row] = minds.desire[row, i]
            code = behavior[row]
            if tires[code]:
                strength[row] *= tiredness(minds.fatigue[code, i], nature.fatigue_s)
                if minds.fatigue[code, i] > 0.0 and code != now and code != minds.memory[i]:
                    strength[row] *= RESTS
        gain = INHIBITION if minds.resumed[i] else GRACE
        for row in range(len(level)):
            if tires[behavior[row]]:
                strength[row] -= gain * _rival(minds.desire[:, i], level, behavior, row, now)
                if strength[row] <= nature.keen:
                    strength[row] = 0.0
        held = minds.memory[i] >= 0
        row = _strongest(strength, level, behavior, now)
        minds.held[i] += minds.pause[i]
        if not lasting[now] and _row_of(strength, behavior, now) >= 0:
            minds.held[i] = 0.0  # its cause is still there
        gives_way = level[row] >= LASTING if lasting[now] else lasting[behavior[row]]
        if gives_way and minds.held[i] < DWELL_S:
            row = _calmest(level, behavior, now)
        wanted = behavior[row]
        if level[row] < LASTING:
            if wanted != now and lasting[now]:
                minds.memory[i] = now
                minds.memory_target[i] = minds.target[i]
            minds.resumed[i] = False
        elif minds.memory[i] >= 0:
            before = _row_of(strength, behavior, minds.memory[i])
            if before >= 0 and level[before] <= level[row] and minds.busy[i] < MEMORY_S:
                wanted = behavior[before]
                minds.target[i] = minds.memory_target[i]
                minds.resumed[i] = True
            minds.memory[i] = -1
        elif wanted != now:
            minds.resumed[i] = False
        # Consecutive reactions are one interruption.
        goes_on = wanted == now or (held and level[row] < LASTING)
        minds.busy[i] = minds.busy[i] + minds.pause[i] if goes_on else 0.0
        if wanted != now and not minds.resumed[i]:
            minds.target[i] = -1
        if wanted != now:
            minds.held[i] = 0.0
        minds.intention[i] = wanted


@kernel
def tiredness(fatigue: float, half: float) -> float:
    """Factor on a desire after `fatigue` s: 1 at first, a half after `half` s."""
    return 0.5 ** ((fatigue / half) ** 2) if fatigue > 0.0 else 1.0


@kernel
def _rival(desire: Array, level: Ints, behavior: Ints, row: int, now: int) -> float:
    """Strength of the followed desire, if `row` is another one on its level; else 0."""
    if behavior[row] == now:
        return 0.0
    most = 0.0
    for rival in range(len(level)):
        if behavior[rival] == now and level[rival] == level[row]:
            most = max(most, float(desire[rival]))
    return most


@kernel
def _strongest(strength: Array, level: Ints, behavior: Ints, now: int) -> int:
    """Row of the winning desire; of equal ones the followed one, else the first."""
    best, most = len(level) - 1, 0.0
    for row in range(len(level)):
        if most > 0.0 and level[row] != level[best]:
            break
        much = strength[row]
        if much > most or (much == most > 0.0 and behavior[row] == now):
            best, most = row, much
    return best


@kernel
def _calmest(level: Ints, behavior: Ints, code: int) -> int:
    """The row of behavior `code`, which has one, on its least urgent level."""
    row = len(level) - 1
    while behavior[row] != code:
        row -= 1
    return row


@kernel
def _row_of(strength: Array, behavior: Ints, code: int) -> int:
    """The first row with a desire for behavior `code`, or -1."""
    for row in range(len(behavior)):
        if behavior[row] == code and strength[row] > 0.0:
            return row
    return -1
