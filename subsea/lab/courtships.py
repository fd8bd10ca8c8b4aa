"""Courtships: their states, success and rejection."""

from typing import NamedTuple

import numpy as np

from subsea.lab.series import headings, runs
from subsea.media.record import Record
from subsea.state import ASCENDING, CIRCLING, LOOPING, NO_COURTSHIP, NOBODY, NUZZLING

TURNED_DEG, TURNED_S = 60.0, 3.0  # a rejected male turns by that angle within that time
COURTED_S = 1.0  # minimum duration of a courtship
SEQUENCE = (LOOPING, CIRCLING, ASCENDING, NUZZLING)  # of a complete mating (Tu §7.9.3)


class Courtship(NamedTuple):
    """The courtship of one male."""

    male: int
    partner: int  # NOBODY if no female accepted
    start: float  # s
    duration: float  # s
    states: tuple[int, ...]  # codes in COURTSHIP, in order of time
    complete: bool
    rejected: bool  # it ended before they circled
    turned_away: bool  # by more than 60° within three seconds after


def courtships(record: Record) -> list[Courtship]:
    """Every courtship of every male, in order of time."""
    found = []
    for i in np.flatnonzero(record.male):
        state = record.courtship[:, i]
        for start, end in runs((state != NO_COURTSHIP) & record.alive[:, i]):
            if (end - start) * record.tick_s < COURTED_S:
                continue
            codes = state[start:end]
            order = tuple(int(k) for k in codes[np.insert(np.diff(codes) != 0, 0, True)])
            partners = record.partner[start:end, i]
            partners = partners[partners != NOBODY]
            over = end < len(record.time)
            rejected = over and not set(order) & {CIRCLING, ASCENDING, NUZZLING}
            found.append(
                Courtship(
                    male=int(i),
                    partner=int(np.bincount(partners).argmax()) if len(partners) else NOBODY,
                    start=float(record.time[start]),
                    duration=(end - start) * record.tick_s,
                    states=order,
                    complete=over and order[-len(SEQUENCE) :] == SEQUENCE,
                    rejected=rejected,
                    turned_away=rejected and turned_after(record, int(i), end - 1) > TURNED_DEG,
                )
            )
    return sorted(found, key=lambda one: (one.start, one.male))


def turned_after(record: Record, fish: int, tick: int) -> float:
    """Largest angle between a fish's heading at a tick and in the three seconds after, degrees."""
    later = tick + 1 + round(TURNED_S / record.tick_s)
    ways = headings(record.orientation[tick:later, fish])
    return float(np.degrees(np.arccos(np.clip(ways @ ways[0], -1.0, 1.0))).max())
