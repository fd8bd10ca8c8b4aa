"""Minds beside measured and wanted ranges, and tables of time budgets."""

from collections.abc import Iterator, Mapping

from subsea.base.findings import RangeCheck
from subsea.fish.measured import MeasuredSwimming, published
from subsea.lab.minds import DAY_H, PURPOSES, MindMeasures, median_survival, shares_of

LEAST_S = 60.0  # fish-seconds of a species whose time budget is compared
ACTIVE = tuple(name for name in PURPOSES if name != "rest")


def mind_findings(label: str, found: MindMeasures, table: MeasuredSwimming) -> Iterator[RangeCheck]:
    """Compare bouts, fear and time budgets of the seas of one label with their ranges."""
    facts, counts, fear = table.minds, found.bouts, found.fear
    whole, calm = int(counts.whole.sum()), int(counts.calm.sum())
    if whole:
        share = counts.short.sum() / whole
        yield RangeCheck(label, "bouts of intention below 0.5 s", share, note=f"{whole} bouts")
    if calm:
        share = counts.calm_short.sum() / calm
        name = "bouts below 0.5 s that no danger ends"
        yield published(label, name, share, "", facts.short, f"of {calm}")
    if fear.minutes:
        flips = fear.flips / fear.minutes
        yield published(label, "passages through alarm of a prey in a minute", flips, "",
                        facts.flips)  # fmt: skip
        lasted = median_survival(fear.lasted, fear.ended)
        note = f"{len(fear.lasted)} times"
        name = "alarm after the last sight of a predator"
        yield published(label, name, lasted, " s", facts.alarm, note)
    yield from _budgets(label, found, table)


def _budgets(label: str, found: MindMeasures, table: MeasuredSwimming) -> Iterator[RangeCheck]:
    """Compare time budgets with those of a reef's day.

    Where a key of the scenario imposes courtship, its time is not a fish's own choice, nor is the
    time that is left to feed: neither has a range.
    """
    facts = table.budget
    for species in sorted({species for species, _ in found.budget}):
        hours = {hour: spent for (one, hour), spent in found.budget.items() if one == species}
        if sum(sum(spent.values()) for spent in hours.values()) < LEAST_S:
            continue
        subject, shares = f"{label}: {species}", shares_of([*hours.values()])
        if species in found.courts:
            note = "courtship is imposed"
            yield RangeCheck(subject, "time feeding", shares["feeding"], note=note)
            yield RangeCheck(subject, "time courting", shares["courting"], note=note)
        elif species not in found.hunters:
            yield published(subject, "time feeding", shares["feeding"], "", facts.feeding)
        by_day = [spent for hour, spent in hours.items() if DAY_H[0] <= hour + 0.5 < DAY_H[1]]
        if by_day and shares["courting"] and species not in found.courts:
            courting = shares_of(by_day)["courting"]
            yield published(subject, "time courting by day", courting, "", facts.courting)
        yield published(subject, "time avoiding", shares["avoiding"], "", facts.avoiding)


def budgets(found: Mapping[str, MindMeasures]) -> list[dict[str, object]]:
    """List shares of time by scenario, species and hour, for JSON."""
    return [
        {"scenario": label, "species": name, "hour": hour, "fish_s": round(sum(spent.values()), 1)}
        | {purpose: round(share, 4) for purpose, share in shares_of([spent]).items()}
        for label, one in found.items()
        for (name, hour), spent in sorted(one.budget.items())
    ]


def budget_lines(found: Mapping[str, MindMeasures]) -> list[str]:
    """Lines of a Markdown table of time budgets by scenario, species and hour; empty without any.

    All shares are of active time, but that of rest.
    """
    rows = budgets(found)
    if not rows:
        return []
    used = dict.fromkeys(key for row in rows for key in row if isinstance(row[key], float))
    del used["fish_s"]
    others = sorted(name for name in used if name not in PURPOSES)
    columns = [*PURPOSES, *others]
    head = ["scenario", "species", "hour", "fish-minutes", *columns]
    lines = [
        "Time budgets: shares of active time, and of rest the share of all time.",
        "",
        "| " + " | ".join(head) + " |",
        "| " + " | ".join(["---"] * len(head)) + " |",
    ]
    for row in rows:
        cells = [str(row["scenario"]), str(row["species"]), str(row["hour"])]
        cells.append(f"{float(str(row['fish_s'])) / 60.0:.0f}")
        cells += [f"{float(str(row.get(name, 0.0))):.0%}" for name in columns]
        lines.append("| " + " | ".join(cells) + " |")
    return lines
