"""`subsea study --validate`: how fishes swim, school and hunt in seas, beside measured fishes.

Trials are run and measured on any process; their measures are joined and compared with ranges from
the literature, in a table, as JSON and as plots.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from msgspec import structs

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.findings import RangeCheck
from subsea.base.progress import count_noun, progress
from subsea.base.report_files import Report, ReportFiles
from subsea.base.system import is_path
from subsea.dive.start import start_world
from subsea.fish.measured import (
    MeasuredSwimming,
    PostureFacts,
    SwimmingFacts,
    load_measured,
    published,
)
from subsea.fish.species import load_species, shipped_species
from subsea.habitat.day import hour_at
from subsea.jobs.workers import Check, Pool
from subsea.lab import hunt_findings, hunting, measures, minds, schooling, swimming, whereabouts
from subsea.lab.hunting import Hunts
from subsea.lab.measures import Outside, Predation
from subsea.lab.mind_findings import budget_lines, budgets, mind_findings
from subsea.lab.minds import MindMeasures
from subsea.lab.schooling import BEARINGS, Schooling
from subsea.lab.simulate import live_records
from subsea.lab.swimming import Counts, Swimming, joined
from subsea.lab.whereabouts import Whereabouts
from subsea.motor.playback import TEMPO
from subsea.repertoire import SEGMENTS
from subsea.scenario.load import load_scenario, scenario_names
from subsea.state import PREDATOR
from subsea.world.world import TICK_S, World

CROWD = {"open-ocean": 3000}  # fishes of a scenario that has more
SCHOOL, SCHOOL_SIZES = "schooling", (10, 64, 144)
HUNT, GROUP_SIZES = "preying", (1, 6, 20)
BLOCK_FISH_TICKS = 3_000_000  # measured at once: about 300 MB
MOST_SAMPLES = 5000  # kept of one run, species and quantity
AIM = "project_aims"
STATES = "tunstrom_2013"  # defines the states of a school
PITCHED, STRAIGHT, IDLE, HOVERING = 0.05, 0.10, 0.10, 0.01  # greatest shares
SLOW_STROUHAL = 0.45  # of a trout at 0.5 L/s (drucker_2005); seas have slow fishes
SHALLOW = 0.05  # greatest share of the time near the surface, of a species that keeps to the ground
CATCHES = 1.0, 4.0  # mean of each predator in three minutes
TIGHTEST = 1  # percentile of radii: measured are least radii, not those of every turn
HASTY = 99  # percentile of speeds in flights and hunts, and of accelerations
MOSTLY = 90  # percentile of rolls
NAN = math.nan


class SeaTrial(NamedTuple):
    """One run to measure."""

    label: str
    scenario: str
    seed: int
    ticks: int
    fish: int | None = None
    changes: tuple[str, ...] = ()
    size: int = 0  # of the school or of the group of prey, for those trials
    hunt: bool = False


class SeaMeasures(NamedTuple):
    """The measures of one run."""

    swims: dict[str, Swimming]  # by name of the species' file
    schools: list[Schooling]
    outside: list[Outside]
    predation: Predation
    minds: MindMeasures | None = None
    places: Mapping[str, Whereabouts] = {}  # by name of the species' file
    hunts: Hunts | None = None  # of a sea with hunters


def default_scenarios() -> list[str]:
    """List the shipped scenarios with fishes."""
    return [name for name in scenario_names() if any(s.number for s in load_scenario(name)[0].fish)]


def trials(
    scenarios: Sequence[str], seeds: Sequence[int], ticks: int, hunt_ticks: int | None = None
) -> Iterator[SeaTrial]:
    """List all runs: scenarios, schools of several sizes, groups of prey with one predator.

    The last two only if their scenarios are among those that are given. The scenario HUNT runs for
    `hunt_ticks` if they are given: a hunter that begins hungry catches more in the first minute
    than in others. UserError for a scenario that cannot be read.
    """
    for name in scenarios:
        chosen = load_scenario(name).scenario
        number = sum(shoal.number for shoal in chosen.fish)
        most = CROWD.get(name, number)
        fish = most if most < number else None
        label = Path(name).stem if is_path(name, ".toml") else name
        label = f"{label} of {fish} fishes" if fish else label
        for seed in seeds:
            lasts = hunt_ticks if name == HUNT and hunt_ticks else ticks
            yield SeaTrial(label, name, seed, lasts, fish)
    for seed in seeds:
        if SCHOOL in scenarios:
            for size in SCHOOL_SIZES:
                yield SeaTrial(f"{SCHOOL} of {size}", SCHOOL, seed, ticks, size, size=size)
        if HUNT in scenarios:
            for size in GROUP_SIZES:
                yield SeaTrial(f"{HUNT} on {size}", HUNT, seed, ticks, None,
                               one_group(HUNT, size), size, hunt=True)  # fmt: skip


def one_group(scenario: str, size: int) -> tuple[str, ...]:
    """Make changes to a scenario that leave its predators and one shoal of `size` prey."""
    changes, found = [], False
    for k, shoal in enumerate(load_scenario(scenario)[0].fish):
        kind = shoal.kind or load_species(shoal.species).kind
        number = shoal.number if kind == "predator" else 0
        if kind == "prey" and not found:
            number, found = size, True
        changes.append(f"fish.{k}.number={number}")
    return tuple(changes)


def run_sea(trial: SeaTrial) -> SeaMeasures:
    """Run and measure one trial, on any process."""
    world = start_world(
        trial.scenario, trial.seed, trial.fish, lambda message: None, changes=trial.changes
    )
    slowest = slowest_strokes(world)
    keys = {load_species(name).name: name for name in shipped_species()}
    swims: dict[str, list[Swimming]] = {}
    schools: list[Schooling] = []
    beyond: list[Outside] = []
    hunts: list[Predation] = []
    rushes: list[Hunts] = []
    thoughts: list[MindMeasures] = []
    places: dict[str, list[Whereabouts]] = {}
    water, courts = world.scenario.water, imposed_courtship(world)
    for record in live_records(world, trial.ticks, BLOCK_FISH_TICKS):
        for name, found in swimming.swimming(record, slowest).items():
            swims.setdefault(keys.get(name, name), []).append(found)
        schools += schooling.schooling(record)
        beyond += measures.outside(record)
        hunts.append(measures.predation(record))
        if (record.kind == PREDATOR).any():
            rushes.append(hunting.hunts(record))
        hours = [hour_at(water.hour, water.day_minutes, float(second)) for second in record.time]
        thoughts.append(minds.mind_measures(record, np.array(hours), courts))
        for name, place in whereabouts.whereabouts(record).items():
            places.setdefault(keys.get(name, name), []).append(place)
    thinned = {name: _thinned(swimming.joined(parts)) for name, parts in swims.items()}
    return SeaMeasures(
        thinned,
        schooling.joined(schools),
        beyond,
        measures.joined(hunts),
        minds.joined(thoughts),
        {name: whereabouts.joined(parts) for name, parts in places.items()},
        hunt_findings.joined(rushes) if rushes else None,
    )


def imposed_courtship(world: World) -> frozenset[str]:
    """Name the species that court by a key of the scenario: libido of a shoal, or a pair."""
    keen, species = world.nature.keen, world.state.fishes.species
    ends = np.cumsum(world.shoal_sizes)
    fishes = [
        fish
        for shoal, end, number in zip(world.scenario.fish, ends, world.shoal_sizes, strict=True)
        for fish in range(end - number, end)
        if (shoal.libido or 0.0) > keen
    ]
    for direction in world.scenario.direction:
        fishes += direction.pair if isinstance(direction.pair, tuple) else ()
    return frozenset(world.species[species[fish]].name for fish in fishes)


def slowest_strokes(world: World) -> Array:
    """Compute the speed (n,) of the slowest stroke of each fish, body lengths a second."""
    fishes, library = world.state.fishes, world.library
    recorded = library.speed[fishes.species, SEGMENTS.index("swim_slow")]
    return np.asarray(TEMPO[0] * recorded * fishes.scale * fishes.rate / fishes.length, np.float64)


def _thinned(found: Swimming) -> Swimming:
    parts: dict[str, Any] = {
        name: value[:: len(value) // MOST_SAMPLES + 1]
        for name, value in found._asdict().items()
        if isinstance(value, np.ndarray)
    }
    return found._replace(**parts)


def run_trials(
    chosen: Iterable[SeaTrial], pool: Pool[int], check: Check = lambda: None
) -> tuple[list[tuple[SeaTrial, SeaMeasures]], list[SeaTrial]]:
    """Run trials; returns them with their measures in their order, and those that crashed.

    `check` is called meanwhile and may raise.
    """
    jobs = dict(enumerate(chosen))
    done: dict[int, SeaMeasures] = {}
    with progress(len(jobs), "run") as count:
        for k, result in pool(run_sea, jobs, check):
            if result is not None:
                done[k] = result
            count()
    crashed = [trial for k, trial in jobs.items() if k not in done]
    return [(jobs[k], done[k]) for k in sorted(done)], crashed


Done = Sequence[tuple[SeaTrial, SeaMeasures]]


class Summary(NamedTuple):
    """All measures by species, by school and by group of prey, for tables and plots."""

    swims: dict[str, Swimming]
    schools: dict[str, list[Schooling]]  # by label
    hunts: dict[int, tuple[int, int]]  # attacks and captures by size of the group
    catches: dict[str, list[float]]  # of each predator, by label
    minds: dict[str, MindMeasures]  # by label
    places: dict[str, Whereabouts]
    rushes: dict[str, list[Hunts]]  # by label


def summarise(done: Done) -> Summary:
    """Join the measures of all trials."""
    swims: dict[str, list[Swimming]] = {}
    thoughts: dict[str, list[MindMeasures]] = {}
    places: dict[str, list[Whereabouts]] = {}
    found = Summary({}, {}, {}, {}, {}, {}, {})
    for trial, (swim, schools, _, hunt, mind, where, rushes) in done:
        if trial.hunt:
            attacks, captures = found.hunts.get(trial.size, (0, 0))
            found.hunts[trial.size] = attacks + hunt.attacks, captures + hunt.captures
            continue
        for name, one in swim.items():
            swims.setdefault(name, []).append(one)
        for name, place in where.items():
            places.setdefault(name, []).append(place)
        if mind:
            thoughts.setdefault(trial.label, []).append(mind)
        if rushes:
            found.rushes.setdefault(trial.label, []).append(rushes)
        if schools:
            found.schools.setdefault(trial.label, []).extend(schools)
        if hunt.catches:
            found.catches.setdefault(trial.label, []).extend(hunt.rates())
    found.swims.update({name: joined(swims[name]) for name in sorted(swims)})
    found.minds.update({label: minds.joined(parts) for label, parts in thoughts.items()})
    found.places.update({name: whereabouts.joined(places[name]) for name in sorted(places)})
    return found


def findings(done: Done, table: MeasuredSwimming) -> list[RangeCheck]:
    """Compare all quantities with their ranges."""
    found = summarise(done)
    rows = [
        row
        for name, one in found.swims.items()
        if name in table.species
        for row in _swimming(name, one, table.species[name], table.posture)
    ]
    for label, schools in found.schools.items():
        rows.extend(_schooling(label, schools, table))
    for name, place in found.places.items():
        rows.extend(_places(name, place, table))
    rows.extend(_hunting(found, table))
    for label, rushes in found.rushes.items():
        rows.extend(hunt_findings.hunt_findings(label, rushes, table.predation, label == HUNT))
    for label, mind in found.minds.items():
        rows.extend(mind_findings(label, mind, table))
    rows.extend(_bounds(done))
    return rows


def _swimming(
    name: str, found: Swimming, facts: SwimmingFacts, posture: PostureFacts
) -> Iterator[RangeCheck]:
    row = partial(published, name)
    if facts.gait != "ray":  # its tail does not drive it
        note = f"{len(found.strouhal)} stretches"
        strouhal = row("Strouhal number", _at(found.strouhal), "", facts.strouhal, note)
        yield strouhal._replace(high=max(strouhal.high, SLOW_STROUHAL))
        yield row("stride", _at(found.stride), " L", facts.slow_stride or facts.stride)
        yield row("beat", _at(found.frequency), " Hz", facts.beat)
        if facts.amplitude:
            measured = facts.slow_amplitude or facts.amplitude
            yield row("tail amplitude", _at(found.amplitude), " L", measured)
    if facts.wave == "carangiform":
        yield row("snout over tail", _at(found.snout_over_tail), "", posture.snout_over_tail)
        yield row("yaw of the head", _at(found.yaw), "°", posture.yaw)
        yield row("roll, 90%", _at(found.roll, MOSTLY), "°", posture.roll)
        part, whole = found.into
        into, note = part / whole if whole else NAN, f"{whole:.0f} ticks"
        yield row("bent into the turn", into, "", posture.into_turn, note)
        pull = _at(found.acceleration, HASTY)
        yield row("acceleration, 99%", pull, " L/s²", posture.acceleration)
    speeds = structs.replace(
        facts.cruise,
        range=(facts.slow.range[0], facts.cruise.range[1]),
        recalled=facts.slow.recalled or facts.cruise.recalled,
    )
    yield row("speed, median", _at(found.speed), " L/s", speeds)
    hasty, note = _at(found.hasty, HASTY), f"{len(found.hasty)} half seconds"
    yield row("speed in flights and hunts, 99%", hasty, " L/s", facts.burst, note)
    tightest, note = _at(found.radius, TIGHTEST), f"{len(found.radius)} turns"
    yield row("turning radius at low speed, tightest hundredth", tightest, " L", facts.radius, note)
    yield _share(name, "ticks pitched over 25°", found.pitched, PITCHED)
    yield _share(name, "change of heading in straight segments", found.straight, STRAIGHT)
    yield _share(name, "time below its slowest stroke", found.idle, IDLE)
    if facts.gait in ("ram", "ray"):
        note = f"{found.longest_hover_s:.0f} s on end at most"
        yield _share(name, "time slower than 0.2 L/s", found.hovering, HOVERING, note)


def _schooling(
    label: str, schools: Sequence[Schooling], table: MeasuredSwimming
) -> Iterator[RangeCheck]:
    facts, row = table.schools, partial(published, label)

    def median(name: str) -> float:
        return _at(np.array([getattr(one, name) for one in schools], np.float64))

    yield row("polarisation", median("polarisation"), "", facts.polarisation,
              f"{len(schools)} schools")  # fmt: skip
    yield row("time with a polarisation below 0.5", median("disorder"), "", facts.disorder)
    yield RangeCheck(label, "order of rotation", median("rotation"), source=STATES)
    states = np.array([one.states for one in schools])
    for k, name in enumerate(("polarised", "milling", "as a swarm")):
        yield RangeCheck(label, f"time {name}", _mean(states[:, k]), source=STATES)
    yield row("nearest neighbour", median("nearest_bl"), " L", facts.nearest)
    yield row("nearest neighbour, 5%", median("near_bl"), " L", facts.near)
    yield row("nearest at 45° and 135° over that at 90°", median("oblique"), "", facts.oblique)
    near, height = (np.array([getattr(one, name) for one in schools]) for name in
                    ("nearest_bl", "height_bl"))  # fmt: skip
    angle = np.degrees(np.arcsin(np.clip(height / near, 0.0, 1.0)))
    yield row("elevation of the nearest", _at(angle), "°", facts.elevation)
    yield row("room for each fish", median("room_bl3"), " L³", facts.room)
    yield row("length over width", median("longer"), "", facts.longer)
    yield row("length over height", median("flatter"), "", facts.flatter)
    lead = "lead of the foremost over the second"
    yield RangeCheck(label, lead, median("ahead_bl"), " L", 0.0, 1.0, AIM)
    variation, slow, gliding = (
        _at(np.array(values)) for values in zip(*(one.rhythm for one in schools), strict=True)
    )
    yield row("variation of a fish's speed", variation, "", facts.variation)
    yield row("time below half of the own median speed", slow, "", facts.slow)
    yield row("time gliding", gliding, "", facts.gliding)
    for name, all_parts in (
        ("longest split", [one.split_s for one in schools]),
        ("longest split without alarm", [one.calm_split_s for one in schools]),
    ):
        parts = np.concatenate(all_parts)
        longest = float(parts.max()) if len(parts) else 0.0
        yield row(name, longest, " s", facts.split, f"{len(parts)} splits")


def _places(name: str, place: Whereabouts, table: MeasuredSwimming) -> Iterator[RangeCheck]:
    facts = table.species.get(name)
    if facts and facts.height:
        yield published(name, "height over the ground", _at(place.height_bl), " L", facts.height)
        yield _share(name, "time near the surface", place.shallow, SHALLOW)


def _hunting(found: Summary, table: MeasuredSwimming) -> Iterator[RangeCheck]:
    rates = {}
    for size, (attacks, captures) in sorted(found.hunts.items()):
        rates[size] = captures / attacks if attacks else NAN
        note = f"{captures} of {attacks} attacks"
        yield RangeCheck("predators", f"captures per attack on {size}", rates[size], note=note)
    if rates:
        most = rates[max(rates)] / rates[min(rates)] if rates[min(rates)] else NAN
        name = f"captures per attack on {max(rates)} over {min(rates)}"
        yield published("predators", name, most, "", table.predation.confusion)
    name = "catches of a predator in 3 min"
    for label, catches in found.catches.items():
        mean, note = float(np.mean(catches)), f"{len(catches)} predators"
        yield RangeCheck(label, f"{name}, mean", mean, "", *CATCHES, AIM, note)
        yield published(label, f"{name}, most", max(catches), "", table.predation.catches)


def _bounds(done: Done) -> Iterator[RangeCheck]:
    """Count fish-ticks outside, by label, and name the worst species."""
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
    """Compute a percentile of the numbers among the values; NaN without any."""
    there = values[np.isfinite(values)]
    return float(np.percentile(there, percentile)) if len(there) else NAN


def _mean(values: Array) -> float:
    """Compute the mean of the numbers among the values; NaN without any."""
    there = values[np.isfinite(values)]
    return float(there.mean()) if len(there) else NAN


def samples(found: Summary) -> Mapping[str, object]:
    """Collect numbers beside the findings, for JSON."""
    return {
        "bearing_shares": {
            label: np.mean([one.bearing for one in schools], axis=0).round(4).tolist()
            for label, schools in found.schools.items()
        },
        "catches": found.catches,
        "time_budgets": budgets(found.minds),
    }


RANGE, OURS = "#E69F00", "#0072B2"
SPREAD = (10, 50, 90)  # percentiles


def _swimming_plot(page: Any, found: Summary, table: MeasuredSwimming) -> None:
    """Draw percentiles of quantities by species over their ranges."""
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
    """Draw order, spacing and splits over the size of the school, and bearings of the nearest."""
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
    """Draw captures per attack over the size of the group."""
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


def _longer(done: Sequence[tuple[SeaTrial, SeaMeasures]], seconds: float) -> str:
    """Name the runs that are longer than `seconds`."""
    named = {f"{one.label} {one.ticks * TICK_S:.0f} s" for one, _ in done
             if one.ticks * TICK_S > seconds}  # fmt: skip
    return f"; {', '.join(sorted(named))}" if named else ""


def validate(jobs: Sequence[SeaTrial], files: ReportFiles, pool: Pool[int], check: Check) -> None:
    """Run trials, print the table and write the files; UserError at the end if runs crashed.

    `check` is called meanwhile and may raise; then nothing is written.
    """
    table = load_measured()
    done, crashed = run_trials(jobs, pool, check)
    found = summarise(done)
    seeds = sorted({trial.seed for trial, _ in done})
    seconds = min((trial.ticks for trial, _ in done), default=0) * TICK_S
    report = Report(
        findings(done, table),
        table.sources,
        extent=f"Seeds {seed_words(seeds)}, {seconds:.0f} s each{_longer(done, seconds)}.",
        below=budget_lines(found.minds),
        more={"seeds": seeds, "seconds": round(seconds, 3), **samples(found)},
        plots={
            name: partial(draw, found=found, table=table) for name, draw in VALIDATION_PLOTS.items()
        },
    )
    files.write(report, check)
    if crashed:
        named = "; ".join(f"{trial.label}, seed {trial.seed}" for trial in crashed[:MAX_NAMED])
        raise UserError(
            f"without {count_noun(len(crashed), 'run', 'runs')} whose process crashed ({named}); "
            "is there enough memory?"
        )


def seed_words(seeds: Sequence[int]) -> str:
    """Write seeds in words: ``1 to 20`` or ``1, 5, 9``."""
    if len(seeds) > 2 and list(seeds) == list(range(seeds[0], seeds[-1] + 1)):
        return f"{seeds[0]} to {seeds[-1]}"
    return ", ".join(map(str, seeds)) or "none"
