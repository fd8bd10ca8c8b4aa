"""Findings of `subsea study --validate`, and its files.

Plots of `subsea study --validate`: swimming, schools and predation beside measured ranges.

Results of `subsea study --validate`: the report of all runs.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.findings import RangeCheck
from subsea.base.progress import count_noun
from subsea.base.report_files import Draw, Report, ReportFiles
from subsea.fish.measured import (
    MeasuredRange,
    MeasuredSwimming,
    SwimmingFacts,
    load_measured,
    published,
)
from subsea.jobs.workers import Check, Pool
from subsea.lab.schooling import BEARINGS, Schooling
from subsea.lab.swimming import Counts, Swimming, joined
from subsea.lab.validation import SeaMeasures, SeaTrial, run_trials
from subsea.world.world import TICK_S

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


RANGE, OURS = "#E69F00", "#0072B2"
SPREAD = (10, 50, 90)  # percentiles


def validation_plots(found: Summary, table: MeasuredSwimming) -> Mapping[str, Draw]:
    """The plots by name of their file (`VALIDATION_PLOTS`)."""
    return {
        name: partial(draw, found=found, table=table) for name, draw in VALIDATION_PLOTS.items()
    }


def _swimming_plot(page: Any, found: Summary, table: MeasuredSwimming) -> None:
    """Percentiles of quantities by species over their ranges."""
    names = [name for name in found.swims if name in table.species]
    page.set_size_inches(12, 1.2 + 0.4 * max(len(names), 4))
    quantities = {
        "strouhal": "Strouhal number",
        "stride": "stride, L",
        "speed": "speed, L/s (range: cruise)",
        "radius": "radius of turns at low speed, L",
    }
    axes = page.subplots(1, len(quantities), sharey=True)
    for axis, (key, title) in zip(axes, quantities.items(), strict=True):
        for k, name in enumerate(names):
            facts = table.species[name]
            if facts.gait == "ray" and key in ("strouhal", "stride"):
                continue  # its tail does not drive it
            fact = getattr(facts, "cruise" if key == "speed" else key)
            axis.plot(fact.range, [k, k], color=RANGE, linewidth=6, alpha=0.6)
            values = getattr(found.swims[name], key)
            if len(values):
                low, middle, high = np.percentile(values, SPREAD)
                axis.plot([low, high], [k, k], color=OURS)
                axis.plot(middle, k, "o", color=OURS, ms=4)
        axis.set(xlabel=title, xlim=(0, None))
    axes[0].set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    page.suptitle("Ours: median, 10% and 90% (blue); measured range (orange)")


def _schools(page: Any, found: Summary, table: MeasuredSwimming) -> None:
    """Order, spacing and splits over the size of the school, and bearings of the nearest."""
    page.set_size_inches(12, 3.4)
    order, near, parts, sides = page.subplots(1, 4)
    schools = [one for those in found.schools.values() for one in those]
    size = [one.fishes for one in schools]
    for axis, values, fact, title in (
        (order, [one.polarisation for one in schools], table.schools.polarisation, "polarisation"),
        (near, [one.nearest_bl for one in schools], table.schools.nearest, "nearest neighbour, L"),
        (parts, [max(one.split_s, default=0.0) for one in schools], table.schools.split,
         "longest split, s"),
    ):  # fmt: skip
        axis.axhspan(*fact.range, color=RANGE, alpha=0.3)
        axis.plot(size, values, "o", color=OURS, ms=3)
        axis.set(xlabel="fishes of the school", ylabel=title, xscale="log", ylim=(0, None))
    if schools:
        share = np.mean([one.bearing for one in schools], axis=0)
        edges = np.degrees(np.arccos(np.linspace(1.0, -1.0, BEARINGS + 1)))
        sides.stairs(share, edges, color=OURS, fill=True)
    sides.axhline(1 / BEARINGS, color="0.5", linestyle="--")
    sides.set(xlabel="bearing of the nearest, °", ylabel="share")


def _predation(page: Any, found: Summary, table: MeasuredSwimming) -> None:
    """Captures per attack over the size of the group."""
    page.set_size_inches(5, 3.4)
    axis = page.subplots()
    sizes = [size for size, (attacks, _) in sorted(found.hunts.items()) if attacks]
    rates = [found.hunts[size][1] / found.hunts[size][0] for size in sizes]
    axis.plot(sizes, rates, "o-", color=OURS)
    for size, rate in zip(sizes, rates, strict=True):
        axis.annotate(f" of {found.hunts[size][0]} attacks", (size, rate))
    axis.set(xlabel="prey in the group", ylabel="captures per attack", ylim=(0, 1.05))


VALIDATION_PLOTS = {
    "validation-swimming.png": _swimming_plot,
    "validation-schools.png": _schools,
    "validation-predation.png": _predation,
}


MAX_NAMED = 5  # crashed runs that an error names


def validate(jobs: Sequence[SeaTrial], files: ReportFiles, pool: Pool[int], check: Check) -> None:
    """Run trials, print the table and write the files; UserError at the end if runs crashed.

    `check` is called meanwhile and may raise; then nothing is written.
    """
    table = load_measured()
    done, crashed = run_trials(jobs, pool, check)
    found = summarise(done)
    seeds = sorted({trial.seed for trial, _ in done})
    seconds = max((trial.ticks for trial, _ in done), default=0) * TICK_S
    report = Report(
        findings(done, table),
        table.sources,
        extent=f"Seeds {seed_words(seeds)}, {seconds:.0f} s each.",
        more={"seeds": seeds, "seconds": round(seconds, 3), **samples(found)},
        plots=validation_plots(found, table),
    )
    files.write(report, check)
    if crashed:
        named = "; ".join(f"{trial.label}, seed {trial.seed}" for trial in crashed[:MAX_NAMED])
        raise UserError(
            f"without {count_noun(len(crashed), 'run', 'runs')} whose process crashed ({named}); "
            "is there enough memory?"
        )


def seed_words(seeds: Sequence[int]) -> str:
    """Seeds in words: ``1 to 20`` or ``1, 5, 9``."""
    if len(seeds) > 2 and list(seeds) == list(range(seeds[0], seeds[-1] + 1)):
        return f"{seeds[0]} to {seeds[-1]}"
    return ", ".join(map(str, seeds)) or "none"
