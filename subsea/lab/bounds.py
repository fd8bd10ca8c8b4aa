"""Fishes out of bounds or inside obstacles, by species."""

from typing import NamedTuple

import numpy as np

from subsea.lab.clearance import BARRIERS, clearances
from subsea.lab.series import runs
from subsea.media.record import Record


class Outside(NamedTuple):
    """Fish-ticks of a species out of bounds or inside obstacles, by snout, middle or tail."""

    species: str
    fish_ticks: int  # alive
    outside: int
    deepest_cm: float  # 0 if none was outside
    barrier: str  # of the deepest, one of BARRIERS
    longest_s: float  # of one fish


def outside(record: Record) -> list[Outside]:
    """Count the fish-ticks outside the free water, for each species in a record.

    A fish that struggles on the hook is lifted out of the water and does not count.
    """
    gaps, which = clearances(record)
    if "struggle" in record.intention_names:
        gaps[record.intention == record.intention_names.index("struggle")] = np.inf
    found = []
    for k, name in enumerate(record.species_names):
        those = np.flatnonzero(record.species == k)
        if not len(those):
            continue
        part = gaps[:, those]
        deepest = np.unravel_index(np.argmin(part), part.shape)
        longest = max(
            (end - start for i in range(len(those)) for start, end in runs(part[:, i] < 0.0)),
            default=0,
        )
        found.append(
            Outside(
                name,
                int(record.alive[:, those].sum()),
                int((part < 0.0).sum()),
                max(-float(part[deepest]), 0.0),
                BARRIERS[which[:, those][deepest]],
                longest * record.tick_s,
            )
        )
    return found
