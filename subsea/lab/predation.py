"""Attacks of predators on prey, and how often they succeed."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.lab.series import runs
from subsea.media.record import Record
from subsea.state import EAT, PREDATOR, PREY

REACH = 1.0  # an attack comes as near as this to its target, lengths of the predator
APART_S = 2.0  # two approaches within this time are one attack
AFTER_S = 1.0  # prey that dies until then was caught by the attack
PERIOD_S = 180.0  # for which catches are counted


class Predation(NamedTuple):
    """Attacks in a record."""

    attacks: int
    captures: int  # attacks that caught prey
    catches: list[int]  # of each predator in the first PERIOD_S of the dive
    seconds: float  # length of the record

    def rates(self) -> list[float]:
        """Catches of each predator in PERIOD_S, scaled from a shorter record."""
        scale = max(PERIOD_S / self.seconds, 1.0)
        return [round(scale * number, 1) for number in self.catches]


def predation(record: Record) -> Predation:
    """Count the attacks and captures of all predators.

    An attack is a period in which the predator hunts and its snout is within its own length of the
    prey that it targets. The predator nearest to prey that dies has caught it.
    """
    seconds = float(record.time[-1] - record.time[0] + record.tick_s)
    hunters = np.flatnonzero(record.kind == PREDATOR)
    caught: dict[int, list[int]] = {int(i): [] for i in hunters}  # ticks
    for t, i in zip(*np.nonzero(record.alive[:-1] & ~record.alive[1:]), strict=True):
        if record.kind[i] == PREY and len(hunters):
            gap = np.linalg.norm(record.snout[t, hunters] - record.position[t, i], axis=1)
            caught[int(hunters[gap.argmin()])].append(int(t))
    attacks = captures = 0
    for i in hunters:
        found = _attacks(record, int(i))
        after = AFTER_S / record.tick_s
        attacks += len(found)
        captures += sum(
            any(start <= t <= end + after for t in caught[int(i)]) for start, end in found
        )
    last = np.searchsorted(record.time, PERIOD_S)
    catches = [sum(bool(t < last) for t in ticks) for ticks in caught.values()]
    return Predation(attacks, captures, catches, seconds)


def joined(parts: Sequence[Predation]) -> Predation:
    """The predation of a dive that was recorded in parts, one after another."""
    return Predation(
        sum(one.attacks for one in parts),
        sum(one.captures for one in parts),
        [sum(numbers) for numbers in zip(*(one.catches for one in parts), strict=True)],
        sum(one.seconds for one in parts),
    )


def _attacks(record: Record, i: int) -> list[tuple[int, int]]:
    """First and last ticks of the attacks of fish i."""
    target = record.target[:, i]
    n = record.position.shape[1]
    aims = (record.intention[:, i] == EAT) & record.alive[:, i] & (target >= 0) & (target < n)
    ticks = np.flatnonzero(aims)
    prey = target[ticks]
    near = np.linalg.norm(record.snout[ticks, i] - record.position[ticks, prey], axis=1)
    close = np.zeros(len(target), np.bool_)
    close[ticks] = (near <= REACH * record.length[i]) & (record.kind[prey] == PREY)
    found: list[tuple[int, int]] = []
    for start, end in runs(close):
        if found and (start - found[-1][1]) * record.tick_s < APART_S:
            found[-1] = found[-1][0], end
        else:
            found.append((start, end))
    return found
