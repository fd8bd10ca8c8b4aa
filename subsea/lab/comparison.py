"""`subsea study` of several records: the measures of each group, with their uncertainty."""

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import fmean, stdev
from textwrap import shorten
from typing import Any, NamedTuple

from subsea.base import interrupts
from subsea.base.errors import UserError, printable
from subsea.base.file_kinds import check_result
from subsea.base.files import replacing
from subsea.base.progress import count_noun, print_line, progress
from subsea.base.report_files import check_plots, write_plots
from subsea.lab.own_measures import OwnMeasure
from subsea.lab.plots import LINES
from subsea.lab.report import MEASURES, Measured, measure, refuse_clashes
from subsea.media.record import BY_MINDS, Origin, read_origin, read_record

Row = dict[str, float | None]  # None: nothing to measure

# Of several schools these are added, or the largest is taken; of others the mean.
_SUMS = "fishes", "splits", "not_rejoined"
_MOST = "longest_split_s"
_OF_SCHOOLS = (
    "fishes", "cruising_share", "polarisation_median", "polarisation_p5", "rotation_median",
    "polarised_share", "milling_share", "swarm_share", "course_deg", "spread_bl",
    "first_by_s", "front_leads", "nearest_bl.p5", "nearest_bl.p50", "nearest_bl.p95", "splits",
    "longest_split_s", "not_rejoined",
)  # fmt: skip
_INPUTS = "seed", "ticks"


def flat_measures(found: Measured) -> Row:
    """Flatten the numbers of `subsea.lab.report.measure` by name, such as ``sea.overlap_share``.

    docs/reference/records.md lists them. Names of species are in lower case with underscores.
    Texts and lists of single events are left out.
    """
    row = {name: value for name, value in _numbers(found).items() if name not in _INPUTS}
    schools = [_numbers(school) for school in found["schools"]]
    row["schools.number"] = float(len(schools))
    for name in _OF_SCHOOLS:
        values = [value for one in schools if (value := one[name]) is not None]
        if name in _SUMS:
            row[f"schools.{name}"] = sum(values, 0.0)
        else:
            whole = max if name == _MOST else fmean
            row[f"schools.{name}"] = round(whole(values), 6) if values else None
    return row


def _numbers(found: Any, prefix: str = "") -> Row:
    row: Row = {}
    for key, value in found.items():
        name = f"{prefix}{key}".lower().replace(" ", "_")
        if isinstance(value, dict):
            row |= _numbers(value, f"{name}.")
        elif value is None or isinstance(value, int | float):
            row[name] = None if value is None else float(value)
    row.pop("sea.least_clearance_from", None)  # a text, or None
    return row


PLOT = "comparison.png"
COLUMNS = 4
PANELS = {
    "minds.changes_per_second": "changes of intention per second",
    "minds.escapes": "escapes",
    "minds.hunger_saturated_share": "hunger saturated, share",
    "captures.lost": "eaten or landed",
    "mating.courtships": "courtships",
    "mating.complete": "complete courtships",
    "food.meals": "meals",
    "food.plankton_end": "plankton at the end",
    "sea.least_clearance_cm": "least clearance, cm",
    "sea.overlap_share": "bodies overlap, share",
    "schools.cruising_share": "schools: cruising, share",
    "schools.polarisation_median": "schools: polarisation",
    "schools.nearest_bl.p50": "schools: nearest neighbour, BL",
    "schools.splits": "schools: splits",
}
"""Measures and the titles of their panels."""


def comparison_page(
    page: Any, groups: Sequence[tuple[str, Sequence[Row]]], estimates: Sequence[Mapping[str, Any]]
) -> None:
    """Draw the records of each group as points, with the mean and its confidence interval.

    `groups` are labels and rows, `estimates` those of each group by measure. Measures that
    are equal in all records have no panel.
    """
    from matplotlib.lines import Line2D

    everyone = [row for _, rows in groups for row in rows]
    names = [name for name in PANELS if len({row.get(name) for row in everyone}) > 1] or ["fishes"]
    down = -(-len(names) // COLUMNS)
    width = 2.6 * min(COLUMNS, len(names))
    legend = 0.25 * len(groups) + 0.2
    page.set_size_inches(max(width, 6.5), 2.2 * down + legend)
    axes = page.subplots(down, min(COLUMNS, len(names)), squeeze=False)
    for panel, name in zip(axes.flat, names, strict=False):
        panel.set_title(PANELS.get(name, name))
        panel.set_xticks(range(len(groups)), [str(k + 1) for k in range(len(groups))])
        panel.set_xlim(-0.6, len(groups) - 0.4)
        for k, (_, rows) in enumerate(groups):
            colour = LINES[k % len(LINES)]
            values = [value for row in rows if (value := row.get(name)) is not None]
            found = estimates[k].get(name)
            panel.plot([k - 0.2] * len(values), values, "o", ms=3, color=colour, alpha=0.4)
            if found is not None and found.mean is not None:
                panel.errorbar(
                    [k], [found.mean], yerr=[found.half_width or 0.0], fmt="s", ms=5,
                    capsize=4, color=colour,
                )  # fmt: skip
    for panel in axes.flat[len(names) :]:
        panel.set_axis_off()
    handles = [
        Line2D([], [], marker="s", ls="", color=LINES[k % len(LINES)]) for k in range(len(groups))
    ]
    labels = [
        f"{k + 1}: {shorten(label, 90)} ({len(rows)})" for k, (label, rows) in enumerate(groups)
    ]
    page.legend(
        handles, labels, loc="outside lower left",
        title="mean with 95% confidence interval; dots: records",
    )  # fmt: skip


CONFIDENCE = 0.95
# Quantiles at 97.5 % of Student's t, by degrees of freedom from 1; and of the normal distribution.
STUDENT = (12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281)
NORMAL = 1.959964


class Estimate(NamedTuple):
    """A measure of a group: its mean, and the 95 % confidence interval of that."""

    number: int  # of records that have the measure
    mean: float | None
    half_width: float | None  # of the interval; None for fewer than two records


class RecordGroup(NamedTuple):
    """Records of one scenario with the same changes, which differ in their seeds."""

    label: str
    origin: Origin
    paths: list[str]
    seeds: list[int]
    rows: list[Row]
    estimates: dict[str, Estimate]


def compare(
    records: Sequence[Path], out: Path | None, report: Path | None, force: bool = False,
    own: Sequence[OwnMeasure] = (),
) -> int:  # fmt: skip
    """Measure several records and print a table of their groups; returns the exit code.

    `out` is a folder for a plot, `report` gets all estimates as JSON. Raises a UserError before any
    work if something cannot be written, or would replace a record or a file of another kind.
    """
    picture = out / PLOT if out else None
    refuse_clashes(records, [path for path in (report, picture) if path])
    if len({os.path.realpath(path) for path in records}) < len(records):
        raise UserError("a record is given twice")
    if report:
        check_result(report, MEASURES, force)
    if out:
        check_plots(out, [PLOT], force)
    with interrupts.deferred_interrupts() as check:
        origins = [read_origin(path) for path in records]
        rows: list[tuple[int, Row]] = []
        with progress(len(records), "record") as count:
            for path in records:
                read = read_record(path)
                rows.append((read.seed, flat_measures(measure(read, check, own))))
                count()
        groups = grouped(records, origins, rows)
        print("\n".join(comparison_table(groups)))
        with ExitStack() as whole:
            if report:
                temporary = whole.enter_context(replacing(report))
                temporary.write_text(json.dumps(_report(groups), indent=1) + "\n", encoding="utf-8")
            if out:
                labelled = [(group.label, group.rows) for group in groups]
                estimates = [group.estimates for group in groups]
                page = partial(comparison_page, groups=labelled, estimates=estimates)
                write_plots(out, {PLOT: page}, check)
    if picture:
        print_line(picture)
    return 0


def grouped(
    paths: Sequence[Path], origins: Sequence[Origin], rows: Sequence[tuple[int, Row]]
) -> list[RecordGroup]:
    """Group records, with estimates, in the order of their first records."""
    found: dict[Origin, list[int]] = {}
    for k, origin in enumerate(origins):
        found.setdefault(origin, []).append(k)
    several = len({(one.title, one.scenario_sha256) for one in found}) > 1
    labels = [_label(origin, several) for origin in found]
    groups = []
    for origin, label, members in zip(found, labels, found.values(), strict=True):
        chosen = [rows[k][1] for k in members]
        label = f"{label} ({origin.fish} fishes)" if labels.count(label) > 1 else label
        groups.append(
            RecordGroup(
                label=label,
                origin=origin,
                paths=[str(paths[k]) for k in members],
                seeds=[rows[k][0] for k in members],
                rows=chosen,
                estimates={name: estimate(chosen, name) for name in _names(chosen)},
            )
        )
    return groups


def _label(origin: Origin, several: bool) -> str:
    if not origin.scenario_sha256:
        return "records of unknown origin"
    changes = " ".join(origin.changes)
    if origin.moved_by != BY_MINDS:
        changes = f"{changes or 'as in the scenario'}, moved by {' and '.join(origin.moved_by)}"
    if several:
        return f"{origin.title}: {changes}" if changes else origin.title
    return changes or "as in the scenario"


def _names(rows: Sequence[Row]) -> list[str]:
    return [*dict.fromkeys(name for row in rows for name in row)]


def estimate(rows: Sequence[Row], name: str) -> Estimate:
    """Estimate the mean of a measure over records, with Student's 95 % confidence interval."""
    values = [value for row in rows if (value := row.get(name)) is not None]
    if not values:
        return Estimate(0, None, None)
    if len(values) == 1:
        return Estimate(1, values[0], None)
    half_width = student(len(values) - 1) * stdev(values) / len(values) ** 0.5
    return Estimate(len(values), fmean(values), half_width)


def student(freedom: int) -> float:
    """Look up the 97.5 % quantile of Student's t; above 10, expand it in 1 / `freedom`."""
    if freedom <= len(STUDENT):
        return STUDENT[freedom - 1]
    z = NORMAL
    return (
        z
        + (z**3 + z) / (4 * freedom)
        + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
        + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * freedom**3)
    )


def comparison_table(groups: Sequence[RecordGroup]) -> list[str]:
    """Format groups as lines of text, without measures that are 0 or missing in all records."""
    letters = [f"group {k + 1}" for k in range(len(groups))]
    lines = [
        f"{letter}: {count_noun(len(group.rows), 'record', 'records')}, {printable(group.label)}"
        for letter, group in zip(letters, groups, strict=True)
    ]
    lines += [
        "",
        f"{'mean ± 95% confidence interval':52s}" + "".join(f"{one:>24s}" for one in letters),
    ]
    for name in _names([row for group in groups for row in group.rows]):
        if any(row.get(name) for group in groups for row in group.rows):
            cells = [_cell(group.estimates.get(name, Estimate(0, None, None))) for group in groups]
            lines.append(f"{name:52s}" + "".join(f"{cell:>24s}" for cell in cells))
    return lines


def _cell(found: Estimate) -> str:
    if found.mean is None:
        return "–"
    if found.half_width is None:
        return f"{found.mean:.4g}"
    return f"{found.mean:.4g} ± {found.half_width:.2g}"


def _report(groups: Sequence[RecordGroup]) -> dict[str, object]:
    return {
        "confidence": CONFIDENCE,
        "groups": [
            {
                "label": group.label,
                **group.origin._asdict(),
                "records": group.paths,
                "seeds": group.seeds,
                "measures": {name: one._asdict() for name, one in group.estimates.items()},
            }
            for group in groups
        ],
    }
