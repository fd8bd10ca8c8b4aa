"""Findings of `subsea study --validate`, and its files."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.findings import RangeCheck
from subsea.fish.measured import MeasuredRange, MeasuredSwimming, SwimmingFacts, published
from subsea.lab.schooling import Schooling
from subsea.lab.swimming import Counts, Swimming, joined
from subsea.lab.validation import SeaMeasures, SeaTrial

AIM = "project_aims"
PITCHED, STRAIGHT, IDLE, HOVERING = 0.05, 0.10, 0.10, 0.01  # greatest shares
SLOW_STROUHAL = 0.45  # of a trout at 0.5 L/s (drucker_2005); seas have slow fishes
CATCHES = 1.0, 4.0  # mean of each predator in three minutes
TIGHTEST = 1  # percentile of radii: measured are least radii, not those of every turn
HASTY = 99  # percentile of speeds in flights and hunts
NAN = math.nan

Done = Sequence[tuple[SeaTrial, SeaMeasures]]


class Summary(NamedTuple):
    """All measures by species, by school and by group of prey, for tables and plots."""

    swims: dict[str, Swimming]
    schools: dict[str, list[Schooling]]  # by label
    hunts: dict[int, tuple[int, int]]  # attacks and captures by size of the group
    catches: dict[str, list[float]]  # of each predator, by label


def summarise(done: Done) -> Summary:
    """Join the measures of all trials."""
    swims: dict[str, list[Swimming]] = {}
    found = Summary({}, {}, {}, {})
    for trial, measures in done:
        if trial.hunt:
            attacks, captures = found.hunts.get(trial.size, (0, 0))
            hunt = measures.predation
            found.hunts[trial.size] = attacks + hunt.attacks, captures + hunt.captures
            continue
        for name, one in measures.swims.items():
            swims.setdefault(name, []).append(one)
        if measures.schools:
            found.schools.setdefault(trial.label, []).extend(measures.schools)
        if measures.predation.catches:
            found.catches.setdefault(trial.label, []).extend(measures.predation.rates())
    found.swims.update({name: joined(swims[name]) for name in sorted(swims)})
    return found


def findings(done: Done, table: MeasuredSwimming) -> list[RangeCheck]:
    """All quantities beside their ranges."""
    found = summarise(done)
    rows = [
        row
        for name, one in found.swims.items()
        if name in table.species
        for row in _swimming(name, one, table.species[name])
    ]
    for label, schools in found.schools.items():
        rows.extend(_schooling(label, schools, table))
    rows.extend(_hunting(found, table))
    rows.extend(_bounds(done))
    return rows


def _swimming(name: str, found: Swimming, facts: SwimmingFacts) -> Iterator[RangeCheck]:
    many = f"{len(found.strouhal)} stretches"
    if facts.gait != "ray":  # its tail does not drive it
        row = published(name, "Strouhal number", _at(found.strouhal), "", facts.strouhal, many)
        yield row._replace(high=max(row.high, SLOW_STROUHAL))
        stride = facts.slow_stride or facts.stride
        yield published(name, "stride", _at(found.stride), " L", stride)
        yield published(name, "beat", _at(found.frequency), " Hz", facts.beat)
        if facts.amplitude:
            amplitude = _at(found.amplitude)
            measured = facts.slow_amplitude or facts.amplitude
            yield published(name, "tail amplitude", amplitude, " L", measured)
    speeds = MeasuredRange(
        range=(facts.slow.range[0], facts.cruise.range[1]),
        of=facts.cruise.of,
        source=facts.cruise.source,
        recalled=facts.slow.recalled or facts.cruise.recalled,
    )
    yield published(name, "speed, median", _at(found.speed), " L/s", speeds)
    note = f"{len(found.hasty)} half seconds"
    yield published(name, "speed in flights and hunts, 99%", _at(found.hasty, HASTY), " L/s",
                    facts.burst, note)  # fmt: skip
    quantity = "turning radius at low speed, tightest hundredth"
    note = f"{len(found.radius)} turns"
    yield published(name, quantity, _at(found.radius, TIGHTEST), " L", facts.radius, note)
    yield _share(name, "ticks pitched over 25°", found.pitched, PITCHED)
    yield _share(name, "change of heading in straight segments", found.straight, STRAIGHT)
    yield _share(name, "time below its slowest stroke", found.idle, IDLE)
    if facts.gait in ("ram", "ray"):
        note = f"{found.longest_hover_s:.0f} s on end at most"
        yield _share(name, "time slower than 0.2 L/s", found.hovering, HOVERING, note)


def _schooling(
    label: str, schools: Sequence[Schooling], table: MeasuredSwimming
) -> Iterator[RangeCheck]:
    facts = table.schools
    note = f"{len(schools)} schools"
    columns = {
        name: np.array([getattr(one, name) for one in schools], np.float64)
        for name in ("polarisation", "nearest_bl", "room_bl3", "height_bl")
    }
    yield published(
        label, "polarisation", _at(columns["polarisation"]), "", facts.polarisation, note
    )
    near = columns["nearest_bl"]
    yield published(label, "nearest neighbour", _at(near), " L", facts.nearest)
    yield published(label, "room for each fish", _at(columns["room_bl3"]), " L³", facts.room)
    angle = np.degrees(np.arcsin(np.clip(columns["height_bl"] / near, 0.0, 1.0)))
    yield published(label, "elevation of the nearest", _at(angle), "°", facts.elevation)
    lead = _at(np.array([one.ahead_bl for one in schools]))
    yield RangeCheck(label, "lead of the foremost over the second", lead, " L", 0.0, 1.0, AIM)
    for name, all_parts in (
        ("longest split", [one.split_s for one in schools]),
        ("longest split without alarm", [one.calm_split_s for one in schools]),
    ):
        parts = np.concatenate(all_parts)
        longest = float(parts.max()) if len(parts) else 0.0
        yield published(label, name, longest, " s", facts.split, f"{len(parts)} splits")


def _hunting(found: Summary, table: MeasuredSwimming) -> Iterator[RangeCheck]:
    rates = {}
    for size, (attacks, captures) in sorted(found.hunts.items()):
        rates[size] = captures / attacks if attacks else NAN
        note = f"{captures} of {attacks} attacks"
        yield RangeCheck("predators", f"captures per attack on {size}", rates[size], note=note)
    if rates:
        most = rates[max(rates)] / rates[min(rates)] if rates[min(rates)] else NAN
        sizes = f"{max(rates)} over {min(rates)}"
        yield published("predators", f"captures per attack on {sizes}", most, "",
                        table.predation.confusion)  # fmt: skip
    for label, catches in found.catches.items():
        yield RangeCheck(label, "catches of a predator in 3 min, mean", float(np.mean(catches)),
                         "", *CATCHES, AIM, f"{len(catches)} predators")  # fmt: skip
        yield published(
            label, "catches of a predator in 3 min, most", max(catches), "", table.predation.catches
        )


def _bounds(done: Done) -> Iterator[RangeCheck]:
    """Fish-ticks outside, by label, and the worst species."""
    labels = dict.fromkeys(trial.label for trial, _ in done)
    for label in labels:
        parts = [one for trial, found in done if trial.label == label for one in found.outside]
        total = sum(one.outside for one in parts)
        note = ""
        if total:
            worst = max(parts, key=lambda one: one.deepest_cm)
            note = (
                f"{worst.species}, {worst.deepest_cm:.0f} cm beyond the {worst.barrier}, "
                f"{max(one.longest_s for one in parts):.1f} s on end"
            )
        yield RangeCheck(label, "fish-ticks out of bounds or in solids", float(total), "", 0.0, 0.0,
                         AIM, note)  # fmt: skip


def _share(name: str, quantity: str, counts: Counts, most: float, note: str = "") -> RangeCheck:
    part, whole = counts
    value = part / whole if whole else NAN
    return RangeCheck(name, quantity, value, "", 0.0, most, AIM, note)


def _at(values: Array, percentile: float = 50) -> float:
    """A percentile of the numbers among the values; NaN without any."""
    there = values[np.isfinite(values)]
    return float(np.percentile(there, percentile)) if len(there) else NAN


def samples(found: Summary) -> Mapping[str, object]:
    """Numbers beside the findings, for JSON."""
    return {
        "bearing_shares": {
            label: np.mean([one.bearing for one in schools], axis=0).round(4).tolist()
            for label, schools in found.schools.items()
        },
        "catches": found.catches,
    }
