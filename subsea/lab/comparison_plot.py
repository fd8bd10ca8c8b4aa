"""The plot of a comparison: a panel for each of the main measures."""

from collections.abc import Mapping, Sequence
from textwrap import shorten
from typing import Any

from subsea.lab.flat_measures import Row
from subsea.lab.plots import LINES

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
