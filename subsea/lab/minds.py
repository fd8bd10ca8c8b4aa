"""Hunger, intentions, meals and escapes."""

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.lab.series import runs
from subsea.media.record import Record
from subsea.state import ESCAPE, FEAR, HUNGER, PREDATOR

SATED_BELOW, SATURATED_S = 0.99, 60.0  # hunger is saturated above this level for this time
WARNING_S = 1.0  # fear must come within this time before an escape


def saturated(record: Record) -> Bools:
    """Fish-ticks (T, n) of plankton eaters whose hunger stays full for over a minute.

    Only while there is plankton.
    """
    full = (record.mental_state[:, :, HUNGER] >= SATED_BELOW) & record.alive
    full &= (record.plankton > 0)[:, None] & (record.kind != PREDATOR)
    found = np.zeros_like(full)
    for i in range(full.shape[1]):
        for start, end in runs(full[:, i]):
            if (end - start) * record.tick_s > SATURATED_S:
                found[start:end, i] = True
    return found


def time_budget(record: Record) -> Array:
    """Share of living time that each species spends on each intention (s, b)."""
    budget = np.zeros((len(record.species_names), len(record.intention_names)))
    species = np.broadcast_to(record.species, record.alive.shape)[record.alive]
    np.add.at(budget, (species, record.intention[record.alive]), 1.0)
    return budget / np.maximum(budget.sum(axis=1, keepdims=True), 1.0)


def changes_per_second(record: Record) -> Array:
    """Changes of intention of each fish (n,) per second of its life."""
    both = record.alive[1:] & record.alive[:-1]
    changed = (np.diff(record.intention.astype(np.int16), axis=0) != 0) & both
    return np.asarray(changed.sum(axis=0) / np.maximum(both.sum(axis=0) * record.tick_s, 1e-9))


def meals(record: Record) -> Bools:
    """Fish-ticks (T, n) in which something was eaten."""
    eaten = np.zeros_like(record.alive)
    eaten[1:] = np.diff(record.last_meal, axis=0) > 0
    return eaten


def escapes(record: Record) -> tuple[int, int]:
    """Number of escapes, and of those with alarming fear within a second before."""
    began = (record.intention[1:] == ESCAPE) & (record.intention[:-1] != ESCAPE)
    window = max(round(WARNING_S / record.tick_s), 1)
    fearful = record.mental_state[:, :, FEAR] > record.alarmed
    times_, fishes = np.nonzero(began & record.alive[1:])
    warned = [
        fearful[max(t + 1 - window, 0) : t + 1, i].any()
        for t, i in zip(times_, fishes, strict=True)
    ]
    return len(warned), int(np.sum(warned))
