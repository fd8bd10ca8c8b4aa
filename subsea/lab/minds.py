"""Minds as seen in a record: bouts of intention, fear of predators, and time budgets."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.periodic import shortest
from subsea.geometry.solids import ray_meets_pillar, ray_meets_rock
from subsea.geometry.vector import vector
from subsea.kernels import kernel
from subsea.lab.measures import headings, runs
from subsea.media.record import Record
from subsea.state import FEAR, PREDATOR, PREY

SHORT_S = 0.5  # a bout of intention below this duration is short
REACTIONS = ("avoid", "escape", "struggle", "shelter", "yield")  # intentions that answer a danger
ALARMED_SCHOOL = "school"  # answers a danger, too, where fear is alarming
NEAR_CM = 400.0  # a predator nearer than this causes half of the greatest fear (Tu §7.4)
FIELD_DEG = 150.0  # half of the field of view (Tu §6.3)
SPELL_S = 0.5  # fear that exceeds alarm within this time of the last sight was caused by it
DAY_H = 7.0, 16.0  # hours without dawn and dusk

# The purposes of intentions. A budget shows every other intention by its own name.
PURPOSES = {
    "feeding": ("eat", "graze", "pick"),
    "courting": ("mate",),
    "avoiding": ("avoid",),
    "rest": ("rest", "shelter"),
}


class Bouts(NamedTuple):
    """Numbers of bouts (b,) by intention."""

    whole: Ints  # with beginning and end
    short: Ints  # of these below SHORT_S
    calm: Ints  # of `whole`, those that no danger ends
    calm_short: Ints  # of these below SHORT_S


class EachBout(NamedTuple):
    """Every bout of intention with a beginning and an end (k,)."""

    fish: Ints
    start: Ints  # tick
    seconds: Array
    code: Ints  # of the intention
    later: Ints  # of the next one
    danger: Bools  # True where a danger ended the bout


def each_bout(record: Record) -> EachBout:
    """List the bouts of intention that neither the record nor a death cuts off.

    A danger ends a bout where the next intention is one of `REACTIONS`, or to school with alarming
    fear.
    """
    doing = record.intention
    fish, before = np.nonzero((np.diff(doing, axis=0) != 0).T)
    same = fish[1:] == fish[:-1]
    start, end, fish = before[:-1][same] + 1, before[1:][same] + 1, fish[1:][same]
    alive = record.alive[end, fish]
    start, end, fish = start[alive], end[alive], fish[alive]
    later = doing[end, fish]
    words = np.array(record.intention_names)[later]
    alarmed = record.mental_state[end, fish, FEAR] > record.alarmed
    danger = np.isin(words, REACTIONS) | ((words == ALARMED_SCHOOL) & alarmed)
    seconds = (end - start) * record.tick_s
    return EachBout(fish, start, seconds, doing[start, fish], later, danger)


def bouts(record: Record) -> Bouts:
    """Count the bouts of each intention, and those below half a second."""
    each, number = each_bout(record), len(record.intention_names)
    short = each.seconds < SHORT_S - 1e-9
    chosen = (np.ones_like(short), short, ~each.danger, short & ~each.danger)
    return Bouts(*(np.bincount(each.code[those], minlength=number) for those in chosen))


class Fear(NamedTuple):
    """Fear of prey while there are predators."""

    flips: int  # crossings of the threshold of alarm, up or down
    minutes: float  # lived by prey
    lasted: Array  # (k,) s, of alarm after the last sight of a predator ...
    ended: Bools  # (k,) ... and whether it ended, rather than was cut off


def fear(record: Record) -> Fear:
    """Measure how often the fear of prey crosses the threshold of alarm, and how long it lasts.

    A predator is seen within `NEAR_CM` and `FIELD_DEG` if no pillar or rock is between. Durations
    begin at the last sight of any predator by an alarmed fish, and end when its fear has fallen to
    the threshold. They are cut off by the next sight, by death and by the end of the record.
    """
    prey = np.flatnonzero(record.kind == PREY)
    hunters = np.flatnonzero(record.kind == PREDATOR)
    alive = record.alive[:, prey]
    if not len(prey) or not len(hunters):
        return Fear(0, 0.0, np.zeros(0), np.zeros(0, np.bool_))
    alarmed = (record.mental_state[:, prey, FEAR] > record.alarmed) & alive
    flips = int(((alarmed[1:] != alarmed[:-1]) & alive[1:] & alive[:-1]).sum())
    seen = predators_seen(record, prey, hunters)
    spell = max(round(SPELL_S / record.tick_s), 1)
    lasted: list[float] = []
    ended: list[bool] = []
    for k in range(len(prey)):
        for _, out in runs(seen[:, k]):
            # The mind may lag by a few ticks behind what its eyes show.
            late = np.flatnonzero(alarmed[max(out - spell, 0) : out, k])
            if out >= len(seen) or not len(late):
                continue
            calm = np.flatnonzero(~alarmed[out:, k])
            again = np.flatnonzero(seen[out:, k] | ~alive[out:, k])
            until_calm = int(calm[0]) if len(calm) else len(seen) - out
            until_cut = int(again[0]) if len(again) else len(seen) - out
            lasted.append(min(until_calm, until_cut) * record.tick_s)
            ended.append(until_calm < until_cut)
    minutes = float(alive.sum()) * record.tick_s / 60.0
    return Fear(flips, minutes, np.array(lasted), np.array(ended, np.bool_))


def predators_seen(record: Record, prey: Ints, hunters: Ints) -> Bools:
    """Flag (T, p) where a fish of `prey` has any of the `hunters` near, in view and not hidden."""
    seen = np.zeros((len(record.time), len(prey)), np.bool_)
    ahead = headings(record.orientation[:, prey])
    eyes = record.snout[:, prey].astype(np.float64)
    for j in hunters:
        gap = shortest(record.position[:, j, None].astype(np.float64) - eyes, record.period)
        far = np.linalg.norm(gap, axis=2)
        near = (far < NEAR_CM) & record.alive[:, j, None] & record.alive[:, prey] & ~seen
        cosine = (gap * ahead).sum(axis=2) / np.maximum(far, 1e-6)
        near &= cosine > np.cos(np.radians(FIELD_DEG))
        t, k = np.nonzero(near)
        there = record.position[t, j].astype(np.float64)
        seen[t, k] = ~hidden(eyes[t, k], there, record.pillars, record.rocks)
    return seen


@kernel
def hidden(eyes: Array, places: Array, pillars: Array, rocks: Array) -> Bools:
    """Flag (k,) where a pillar or a rock is between an eye and a place (k, 3)."""
    found = np.zeros(len(eyes), np.bool_)
    for k in range(len(eyes)):
        eye, place = vector(eyes[k]), vector(places[k])
        for solid in range(len(pillars)):
            found[k] |= ray_meets_pillar(pillars[solid], 0.0, eye, place) <= 1.0
        for solid in range(len(rocks)):
            found[k] |= ray_meets_rock(rocks[solid], 0.0, eye, place) <= 1.0
    return found


def median_survival(lasted: Array, ended: Bools) -> float:
    """Estimate the median of durations (k,), some of them cut off (Kaplan and Meier 1958).

    It is the longest duration where more than half of them outlast all that ended; NaN without any.
    """
    if not len(lasted):
        return float("nan")
    order = np.lexsort((~ended, lasted))
    share = 1.0
    for place, k in enumerate(order):
        if ended[k]:
            share *= 1.0 - 1.0 / (len(order) - place)
            if share <= 0.5:
                return float(lasted[k])
    return float(lasted.max())


Budget = dict[tuple[str, int], dict[str, float]]
"""Seconds by intention, for each species and hour."""


def time_budgets(record: Record, hour: Array) -> Budget:
    """Measure the seconds of living time for each intention, by species and whole hour.

    `hour` (T,) is the hour of the day of each tick.
    """
    budget: Budget = {}
    hours = np.floor(hour).astype(np.int64) % 24
    for k, name in enumerate(record.species_names):
        those = record.species == k
        for one in np.unique(hours):
            ticks = np.flatnonzero(hours == one)
            alive = record.alive[ticks][:, those]
            doing = record.intention[ticks][:, those][alive]
            seconds = np.bincount(doing, minlength=len(record.intention_names)) * record.tick_s
            if seconds.sum() > 0.0:
                rows = zip(record.intention_names, seconds.tolist(), strict=True)
                budget[name, int(one)] = {intention: s for intention, s in rows if s > 0.0}
    return budget


def shares_of(budget: Sequence[dict[str, float]]) -> dict[str, float]:
    """Add up budgets and return the share of each of `PURPOSES` and of every other intention.

    Purposes are shares of active time, which is without rest; rest is a share of all time.
    """
    seconds: dict[str, float] = {}
    for one in budget:
        for name, value in one.items():
            seconds[name] = seconds.get(name, 0.0) + value
    purpose_of = {name: purpose for purpose, names in PURPOSES.items() for name in names}
    sums = dict.fromkeys(PURPOSES, 0.0)
    for name, value in seconds.items():
        purpose = purpose_of.get(name, name)
        sums[purpose] = sums.get(purpose, 0.0) + value
    whole = sum(sums.values())
    active = max(whole - sums["rest"], 1e-9)
    return {
        name: value / (max(whole, 1e-9) if name == "rest" else active)
        for name, value in sums.items()
    }


class MindMeasures(NamedTuple):
    """All measures of minds of one run or several."""

    intentions: tuple[str, ...]
    bouts: Bouts
    fear: Fear
    budget: Budget
    hunters: frozenset[str]  # species of predators
    courts: frozenset[str] = frozenset()  # species whose courtship the scenario imposes


def mind_measures(
    record: Record, hour: Array, courts: frozenset[str] = frozenset()
) -> MindMeasures:
    """Measure all minds of a record, whose ticks have the `hour` (T,) of the day.

    `courts` are the species whose courtship a key of the scenario imposes.
    """
    hunters = {record.species_names[k] for k in record.species[record.kind == PREDATOR]}
    return MindMeasures(
        tuple(record.intention_names),
        bouts(record),
        fear(record),
        time_budgets(record, hour),
        frozenset(hunters),
        courts,
    )


def joined(parts: Sequence[MindMeasures]) -> MindMeasures:
    """Join the measures of several records with the same intentions."""
    names, all_bouts, fears, budgets, hunters, courts = zip(*parts, strict=True)
    return MindMeasures(
        names[0],
        joined_bouts(all_bouts),
        joined_fear(fears),
        joined_budget(budgets),
        frozenset().union(*hunters),
        frozenset().union(*courts),
    )


def joined_bouts(parts: Sequence[Bouts]) -> Bouts:
    """Add up the bouts of several records with the same intentions."""
    return Bouts(*(np.sum(columns, axis=0) for columns in zip(*parts, strict=True)))


def joined_fear(parts: Sequence[Fear]) -> Fear:
    """Join the fears of several records."""
    flips, minutes, lasted, ended = zip(*parts, strict=True)
    return Fear(sum(flips), sum(minutes), np.concatenate(lasted), np.concatenate(ended))


def joined_budget(parts: Sequence[Budget]) -> Budget:
    """Add up time budgets."""
    budget: Budget = {}
    for part in parts:
        for key, seconds in part.items():
            sums = budget.setdefault(key, {})
            for name, value in seconds.items():
                sums[name] = sums.get(name, 0.0) + value
    return budget
