"""`subsea study`: measure a record; show the measures as a table, as JSON and as plots."""

import json
import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.base import interrupts
from subsea.base.errors import UserError
from subsea.base.file_kinds import check_result, json_file
from subsea.base.files import replacing
from subsea.base.progress import count_noun, print_line
from subsea.base.report_files import check_plots
from subsea.lab import measures
from subsea.lab.leadership import Leadership, leadership
from subsea.lab.own_measures import OwnMeasure
from subsea.lab.plots import RECORD_PLOTS, plot
from subsea.lab.schooling import School, schools, splits, states
from subsea.media.record import Record, read_record

Measured = dict[str, Any]  # by name, for JSON

MEASURES = json_file("a report of `subsea study`", "minds", "groups")


def study(
    record: Path, out: Path | None, report: Path | None, force: bool = False,
    own: Sequence[OwnMeasure] = (),
) -> int:  # fmt: skip
    """Measure the record in a file and print a table; returns the exit code.

    `out` is a folder for plots, `report` gets the measures as JSON. Raises a UserError before any
    work if something cannot be read, written or plotted, or would replace the record or, without
    `force`, a file of another kind. Ctrl-C leaves no result.
    """
    plots = [out / name for name in RECORD_PLOTS] if out else []
    refuse_clashes([record], [*([report] if report else []), *plots])
    if report:
        check_result(report, MEASURES, force)
    if out:
        check_plots(out, RECORD_PLOTS, force)
    # In compiled code Ctrl-C would surface as another error.
    with interrupts.deferred_interrupts() as check:
        read = read_record(record)
        found = measure(read, check, own)
        print("\n".join(table(found)))
        with ExitStack() as whole:
            if report:
                temporary = whole.enter_context(replacing(report))
                temporary.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
            drawn = plot(read, out, check) if out else []
    for path in drawn:
        print_line(path)
    return 0


def refuse_clashes(records: Sequence[Path], results: list[Path]) -> None:
    """Raise a UserError if a result would replace a record or another result."""
    taken = {os.path.realpath(record): "the record" for record in records}
    for result in results:
        place = os.path.realpath(result)
        if place in taken:
            raise UserError(f"is {taken[place]} too, expected another name", file=result)
        taken[place] = "another result"


def measure(
    record: Record, check: Callable[[], None] = lambda: None, own: Sequence[OwnMeasure] = ()
) -> Measured:
    """Compute all measures of docs/reference/records.md; None where there is nothing to measure.

    `check`, which may raise, is called between two of them. `own` are more, by their names.
    """
    ticks, n = record.alive.shape
    found: Measured = {
        "seed": record.seed,
        "ticks": ticks,
        "seconds": round(ticks * record.tick_s, 3),
        "fishes": n,
        "species": {name: int((record.species == k).sum()) for k, name in enumerate(record.keys)},
    }
    parts = {"sea": _sea, "minds": _minds, "schools": _schools, "captures": _captures,
             "mating": _mating, "food": _food}  # fmt: skip
    for name, part in parts.items():
        check()
        found[name] = part(record)
    if own:
        found["own"] = {one.name: one.of(record) for one in own}
    check()
    return found


def _sea(record: Record) -> Measured:
    clearance, which = measures.clearances(record)
    touching = measures.overlaps(record)[record.alive]
    least = np.unravel_index(np.argmin(clearance), clearance.shape)
    alive = int(record.alive.sum())
    return {
        "fish_ticks": alive,
        "out_of_bounds_or_inside": int((clearance < 0).sum()),
        "least_clearance_cm": _rounded(clearance[least]) if alive else None,
        "least_clearance_from": measures.BARRIERS[which[least]] if alive else None,
        "overlap_share": _share(touching == 2, 6),
        "meant_overlap_share": _share(touching == 1, 6),
    }


def _minds(record: Record) -> Measured:
    changes = measures.changes_per_second(record)
    began, warned = measures.escapes(record)
    budget = measures.time_budget(record)
    return {
        "changes_per_second": _rounded(changes.mean()),
        "changes_per_second_most": _rounded(changes.max()),
        "hunger_saturated_share": _share(measures.saturated(record)[record.alive], 6),
        "escapes": began,
        "escapes_after_fear_share": _rounded(warned / began) if began else None,
        "time_budget": {
            name: {
                intention: _rounded(share)
                for intention, share in zip(record.intention_names, row, strict=True)
            }
            for name, row in zip(record.keys, budget, strict=True)
        },
    }


def _schools(record: Record) -> list[Measured]:
    end = float(record.time[-1])
    return [_school(one, leadership(record, one.leader), end) for one in schools(record)]


def _school(school: School, leads: Leadership, end: float) -> Measured:
    cruising = school.polarisation[school.cruises]
    parts = splits(school, end)
    return {
        "leader": school.leader,
        "fishes": int(school.members.max()),
        "cruising_share": _share(school.cruises),
        "polarisation_median": _percentile(cruising, 50),
        "polarisation_p5": _percentile(cruising, 5),
        "rotation_median": _percentile(school.rotation[school.cruises], 50),
        **{f"{name}_share": _rounded(share) for name, share in states(school).items()},
        "course_deg": _course_deg(school),
        "spread_bl": _percentile(school.extent[school.cruises], 50),
        "first_fish": leads.first,
        "first_by_s": _percentile(leads.delay_s, 100),
        "front_leads": _percentile(np.array([leads.front_correlation]), 50),
        "nearest_bl": {
            f"p{k}": _percentile(school.distances, k) for k in (5, 50, 95)
        },
        "splits": len(parts),
        "longest_split_s": _rounded(max((s.duration for s in parts), default=0.0)),
        "not_rejoined": sum(not s.rejoined for s in parts),
        "each_fish": [
            {"fish": int(fish), "delay_s": _known(delay), "front_bl": _rounded(front)}
            for fish, delay, front in zip(leads.fish, leads.delay_s, leads.front_bl, strict=True)
        ],
        "each_split": [
            {"start_s": _rounded(s.start), "lasted_s": _rounded(s.duration),
             "apart_share": _rounded(s.apart), "rejoined": s.rejoined}
            for s in parts
        ],
    }  # fmt: skip


def _course_deg(school: School) -> float | None:
    """Compute the direction in which a school went in the second half of a record, degrees."""
    late = school.time > 0.5 * school.time[-1]
    if not late.any():
        return None
    weight, course = school.polarisation[late], school.course[late]
    east, north = (weight * np.cos(course)).sum(), (weight * np.sin(course)).sum()
    return _rounded(np.degrees(np.arctan2(north, east)))


def _captures(record: Record) -> Measured:
    caught = measures.captures(record)
    together, alone = (
        {
            "caught": number,
            "exposed_fish_s": round(seconds, 1),
            "caught_per_1000_fish_s": _rounded(1000 * number / seconds) if seconds else None,
        }
        for number, seconds in zip(caught.caught, caught.exposed_s, strict=True)
    )
    hunts = measures.predation(record)
    return {
        "lost": caught.lost, "attacks": hunts.attacks, "successful_attacks": hunts.captures,
        "prey_in_company": together, "prey_alone": alone,
    }  # fmt: skip


def _mating(record: Record) -> Measured:
    names = record.courtship_names
    found = measures.courtships(record)
    return {
        "courtships": len(found),
        "complete": sum(one.complete for one in found),
        "rejected": sum(one.rejected for one in found),
        "rejected_and_turned_away": sum(one.turned_away for one in found),
        "each": [
            {"male": one.male, "partner": one.partner, "start_s": _rounded(one.start),
             "lasted_s": _rounded(one.duration), "states": [names[k] for k in one.states],
             "complete": one.complete, "rejected": one.rejected, "turned_away": one.turned_away}
            for one in found
        ],
    }  # fmt: skip


def _food(record: Record) -> Measured:
    eaten = measures.meals(record)
    minutes = record.alive.sum(axis=0) * record.tick_s / 60.0
    of = [record.species == k for k in range(len(record.species_names))]
    return {
        "plankton_start": int(record.plankton[0]),
        "plankton_least": int(record.plankton.min()),
        "plankton_end": int(record.plankton[-1]),
        "meals": int(eaten.sum()),
        "meals_per_fish_minute": {
            name: _rounded(eaten[:, those].sum() / max(float(minutes[those].sum()), 1e-9))
            for name, those in zip(record.keys, of, strict=True)
        },
    }


def _known(value: float) -> float | None:
    return None if np.isnan(value) else _rounded(value)


def _rounded(value: Any) -> float:
    return round(float(value), 4)


def _share(flags: NDArray[np.bool_], digits: int = 4) -> float:
    return round(float(flags.mean()), digits) if flags.size else 0.0


def _percentile(values: NDArray[Any], which: float) -> float | None:
    values = values[np.isfinite(values)]
    return _rounded(np.percentile(values, which)) if values.size else None


def table(found: Measured) -> list[str]:
    """Format measures as lines of text."""
    sea, minds, food = found["sea"], found["minds"], found["food"]
    species = ", ".join(f"{number} {name}" for name, number in found["species"].items())
    lines = [
        f"{count_noun(found['ticks'], 'tick', 'ticks')} ({found['seconds']:g} s) of "
        f"{count_noun(found['fishes'], 'fish', 'fishes')}, seed {found['seed']}: {species}",
        "",
        _line("out of bounds or in an obstacle", f"{sea['out_of_bounds_or_inside']:,} of "
              f"{sea['fish_ticks']:,} fish-ticks"),
        _line("least clearance", f"{sea['least_clearance_cm']:.1f} cm from the "
              f"{sea['least_clearance_from']}" if sea["fish_ticks"] else "nobody lives"),
        _line("bodies overlap", f"{sea['overlap_share']:.3%} of fish-ticks, and "
              f"{sea['meant_overlap_share']:.3%} intended (courting, hunting)"),
        _line("changes of intention", f"{minds['changes_per_second']:.2f} a second and fish, "
              f"at most {minds['changes_per_second_most']:.2f}"),
        _line("hunger saturated", f"{minds['hunger_saturated_share']:.2%} of fish-ticks"),
        _line("plankton", f"{food['plankton_start']} specks, at least {food['plankton_least']}, "
              f"{food['plankton_end']} in the end; {food['meals']} meals"),
        _line("escapes", _escapes(minds)),
        *_caught(found["captures"]),
        *_mated(found["mating"]),
        "",
        *_budget(minds["time_budget"], food["meals_per_fish_minute"]),
    ]  # fmt: skip
    return lines + _school_rows(found["schools"]) + _own_rows(found.get("own", {}))


def _own_rows(own: Measured) -> list[str]:
    """Format measures of a program or of another package."""
    rows: Measured = {}
    for name, value in own.items():
        parts = value if isinstance(value, dict) else {"": value}
        rows |= {f"{name} {part}".rstrip(): number for part, number in parts.items()}
    lines = [_line(name, "–" if value is None else f"{value:g}") for name, value in rows.items()]
    return ["", *lines] if lines else []


def _line(name: str, value: str) -> str:
    return f"{name:32s} {value}"


def _escapes(minds: Measured) -> str:
    if not minds["escapes"]:
        return "none"
    after = f"{minds['escapes_after_fear_share']:.1%} with alarming fear before they begin"
    return f"{minds['escapes']}, {after}"


def _caught(captures: Measured) -> list[str]:
    if not captures["lost"]:
        return [_line("eaten or landed", "nobody")]
    parts = []
    for name in ("prey_in_company", "prey_alone"):
        rate = captures[name]["caught_per_1000_fish_s"]
        words = f"{name.replace('_', ' ')} {captures[name]['caught']}"
        parts.append(words if rate is None else f"{words} ({rate:.2f} in 1000 fish-seconds)")
    return [_line("eaten or landed", f"{captures['lost']}: " + ", ".join(parts))]


def _mated(mating: Measured) -> list[str]:
    if not mating["courtships"]:
        return [_line("courtships", "none")]
    rejected = f"{mating['rejected']} rejected ({mating['rejected_and_turned_away']} turned away)"
    counts = f"{mating['courtships']}, {mating['complete']} complete, {rejected}"
    lines = [_line("courtships", counts)]
    for one in mating["each"][:12]:
        partner = one["partner"] if one["partner"] >= 0 else "nobody"
        lines.append(
            _line("", f"{one['start_s']:6.1f} s  {one['male']} with {partner}: "
                  + " → ".join(one["states"]))
        )  # fmt: skip
    return lines


def _budget(budget: Measured, meals: Measured) -> list[str]:
    intentions = list(next(iter(budget.values())))
    head = f"{'time budget':26s}" + "".join(f"{name:>9s}" for name in intentions)
    lines = [head + "   meals a minute"]
    for name, row in budget.items():
        shares = "".join(f"{row[intention]:9.1%}" for intention in intentions)
        lines.append(f"{name:26s}{shares}{meals[name]:17.2f}")
    return lines


def _school_rows(schools: list[Measured]) -> list[str]:
    if not schools:
        return []
    lines = [
        "",
        "school of  fishes  cruises  polarisation (5%)  nearest neighbour, BL (5–95%)  splits  "
        "longest",
    ]
    for one in schools:
        near = one["nearest_bl"]
        values = (one["polarisation_median"], one["polarisation_p5"], *near.values())
        if None in values:
            middle = f"{'–':>19s}  {'–':>29s}"
        else:
            polarised = f"{values[0]:.2f} ({values[1]:.2f})"
            spaced = f"{values[3]:.2f} ({values[2]:.2f}–{values[4]:.2f})"
            middle = f"{polarised:>19s}  {spaced:>29s}"
        longest = f"{one['longest_split_s']:.1f} s" if one["splits"] else "–"
        if one["not_rejoined"]:
            longest += ", not rejoined"
        lines.append(
            f"{one['leader']:9d}{one['fishes']:8d}{one['cruising_share']:9.0%}{middle}"
            f"{one['splits']:8d}  {longest}"
        )
    return lines
