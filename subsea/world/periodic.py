"""Bring fishes that left a box with periodic sides in again on the other side."""

from collections.abc import Iterator

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.periodic import laps_of
from subsea.state import Fishes, Minds, declared


def wrap(fishes: Fishes, minds: Minds) -> None:
    """Shift fishes beyond the sides of their box by its period; without a box change nothing.

    All places that belong to a fish are shifted with it, in its body and in its memory: so the way
    to each of them stays the same, and a picture between two ticks shows no leap.
    """
    if not fishes.period[0]:
        return
    shift = laps_of(fishes.position, fishes.period) * fishes.period
    left = np.flatnonzero(shift.any(axis=1))
    if len(left):
        for places in places_of(fishes, minds):
            places[left, :2] -= shift[left]


def places_of(fishes: Fishes, minds: Minds) -> Iterator[Array]:
    """List the arrays (n, 3) that hold a place for each fish."""
    groups: tuple[tuple[type, object], ...] = ((Fishes, fishes), (Minds, minds))
    for kind, group in groups:
        for name, spec in declared(kind).items():
            if spec.shape == ("n", 3) and spec.unit == "cm":
                yield getattr(group, name)
