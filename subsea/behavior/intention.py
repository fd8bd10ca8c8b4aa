"""The intention generator: a hierarchy of desires, with memory, inhibition and fatigue."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.state import Minds, Nature

Flags = NDArray[np.bool_]
Ints = NDArray[np.integer[Any]]

# Share of the active desire's strength that its rivals lose: of one that was resumed (Tu §7.7.2),
# and of any other, so that two equal desires that tire do not take turns at every thought.
INHIBITION, GRACE = 0.2, 0.05
MEMORY_S = 12.0  # what was interrupted for longer is forgotten
LASTING = 2  # level from which an intention is worth remembering: earlier ones are reactions


@njit(cache=True, error_model="numpy")
def choose(
    who: Ints, minds: Minds, nature: Nature, level: Ints, behavior: Ints, tires: Flags
) -> None:
    """Set the intention of the fishes `who` (Tu fig. 7.4, of which 7.9 and 7.12 are cases).

    `minds.desire` has a row for each of d desires; `level` and `behavior` (d,) say on which
    level of the hierarchy it is and what it leads to, most urgent first. The strongest desire on
    the first level that has any wins. An intention that a reaction interrupts is remembered with
    what it was about, and resumed once the reaction is over; then it inhibits its rivals (Tu
    §7.7). A desire whose behavior `tires` (b,) fades while it is followed, and recovers after.
    """
    for i in who:
        now = minds.intention[i]
        _tire(minds, i, tires)
        row = _strongest(minds, i, nature, level, behavior, tires)
        wanted = behavior[row]
        if level[row] < LASTING:
            if wanted != now and _is_lasting(now, level, behavior):
                minds.memory[i] = now
                minds.memory_target[i] = minds.target[i]
            minds.resumed[i] = False
        elif minds.memory[i] >= 0:
            before = _row_of(minds, i, minds.memory[i], nature, level, behavior, tires)
            if before >= 0 and level[before] <= level[row] and minds.busy[i] < MEMORY_S:
                wanted = behavior[before]
                minds.target[i] = minds.memory_target[i]
                minds.resumed[i] = True
            minds.memory[i] = -1
        elif wanted != now:
            minds.resumed[i] = False
        minds.busy[i] = minds.busy[i] + minds.pause[i] if wanted == now else 0.0
        if wanted != now and not minds.resumed[i]:
            minds.target[i] = -1
        minds.intention[i] = wanted


@njit(cache=True, error_model="numpy")
def strength(
    minds: Minds, i: int, row: int, nature: Nature, level: Ints, behavior: Ints, tires: Flags
) -> float:
    """How strong desire `row` of fish i is after fatigue and inhibition; 0 if not worth it."""
    desire = minds.desire[row, i]
    if desire <= 0.0 or not tires[behavior[row]]:
        return desire
    desire *= tiredness(minds.fatigue[behavior[row], i], nature.fatigue_s)
    now = minds.intention[i]
    if now != behavior[row]:
        gain = INHIBITION if minds.resumed[i] else GRACE
        for rival in range(len(level)):
            if behavior[rival] == now and level[rival] == level[row]:
                desire -= gain * max(minds.desire[rival, i], 0.0)
    return desire if desire > nature.keen else 0.0


@njit(cache=True, error_model="numpy")
def tiredness(fatigue: float, half: float) -> float:
    """What remains of a desire after so many s: nearly all at first, half of it after `half`."""
    return 0.5 ** ((fatigue / half) ** 2)


@njit(cache=True, error_model="numpy")
def _strongest(
    minds: Minds, i: int, nature: Nature, level: Ints, behavior: Ints, tires: Flags
) -> int:
    """Row of the desire that wins; of equals the one that is being followed, else the first."""
    best, most = len(level) - 1, 0.0
    for row in range(len(level)):
        if most > 0.0 and level[row] != level[best]:
            break
        much = strength(minds, i, row, nature, level, behavior, tires)
        if much > most or (much == most > 0.0 and behavior[row] == minds.intention[i]):
            best, most = row, much
    return best


@njit(cache=True, error_model="numpy")
def _row_of(
    minds: Minds, i: int, code: int, nature: Nature, level: Ints, behavior: Ints, tires: Flags
) -> int:
    """The first row by which fish i still wants behavior `code`, -1 if it doesn't."""
    for row in range(len(level)):
        if behavior[row] == code and strength(minds, i, row, nature, level, behavior, tires) > 0.0:
            return row
    return -1


@njit(cache=True, error_model="numpy")
def _is_lasting(code: int, level: Ints, behavior: Ints) -> bool:
    """Whether behavior `code` may be more than a reaction."""
    lasting = False
    for row in range(len(level)):
        lasting = lasting or (behavior[row] == code and level[row] >= LASTING)
    return lasting


@njit(cache=True, error_model="numpy")
def _tire(minds: Minds, i: int, tires: Flags) -> None:
    """Count the time for which each behavior has been followed, and has been rested from."""
    for code in range(len(tires)):
        if tires[code]:
            active = 1.0 if minds.intention[i] == code else -1.0
            spent = minds.fatigue[code, i] + active * minds.pause[i]
            minds.fatigue[code, i] = max(spent, 0.0)
