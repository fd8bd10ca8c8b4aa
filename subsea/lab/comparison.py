"""`subsea study` of several records: the measures of each group, with their uncertainty."""

import json
import os
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import fmean, stdev
from typing import NamedTuple

from subsea.base import interrupts
from subsea.base.atomic_io import replacing
from subsea.base.console import count_noun
from subsea.base.errors import UserError
from subsea.base.file_kinds import check_result
from subsea.base.plot_files import check_plots, write_plots
from subsea.base.progress import progress
from subsea.lab.comparison_plot import PLOT, comparison_page
from subsea.lab.flat_measures import Row, flat_measures
from subsea.lab.report import MEASURES, measure, refuse_clashes
from subsea.media.record import Origin, read_origin, read_record

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
    records: Sequence[Path], out: Path | None, report: Path | None, force: bool = False
) -> int:
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
                rows.append((read.seed, flat_measures(measure(read, check))))
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
        print(picture)
    return 0


def grouped(
    paths: Sequence[Path], origins: Sequence[Origin], rows: Sequence[tuple[int, Row]]
) -> list[RecordGroup]:
    """The groups of records with their estimates, in the order of their first records."""
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
    if several:
        return f"{origin.title}: {changes}" if changes else origin.title
    return changes or "as in the scenario"


def _names(rows: Sequence[Row]) -> list[str]:
    return [*dict.fromkeys(name for row in rows for name in row)]


def estimate(rows: Sequence[Row], name: str) -> Estimate:
    """The mean of a measure over records, with Student's 95 % confidence interval."""
    values = [value for row in rows if (value := row.get(name)) is not None]
    if not values:
        return Estimate(0, None, None)
    if len(values) == 1:
        return Estimate(1, values[0], None)
    half_width = student(len(values) - 1) * stdev(values) / len(values) ** 0.5
    return Estimate(len(values), fmean(values), half_width)


def student(freedom: int) -> float:
    """The quantile at 97.5 % of Student's t; an expansion in 1 / `freedom` for more than 10."""
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
        f"{letter}: {count_noun(len(group.rows), 'record', 'records')}, {group.label}"
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
