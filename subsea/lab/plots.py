"""Plots of a record: time budgets, schools, minds, paths and clearance."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.report_files import write_plots
from subsea.geometry.walls import is_wall, tank_of
from subsea.lab.measures import BARRIERS, SAMPLE_S, clearances, meals, time_budget
from subsea.lab.schooling import LINK_BL, WHOLE, schools
from subsea.media.record import Record

# The palette of Okabe and Ito, safe for colour-blind readers; then others for new intentions.
INTENTION_COLOURS = {
    "avoid": "#E69F00",
    "escape": "#D55E00",
    "school": "#0072B2",
    "eat": "#009E73",
    "mate": "#CC79A7",
    "leave": "#F0E442",
    "wander": "#BFC7CE",
    "curious": "#56B4E9",
    "graze": "#8C564B",
    "pick": "#66C2A5",
    "shelter": "#17324D",
    "clean": "#7F3C8D",
}
MORE_COLOURS = ("#A5AA99", "#F4A6A6", "#B8860B", "#C7B6E5", "#6B6259", "#B3DE69")
DARK = 0.45  # brightness of a colour below which text on it is white
LINES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7F3C8D", "#8C564B")
MENTAL_COLOURS = ("#009E73", "#CC79A7", "#D55E00")
BARRIER_COLOURS = ("#17324D", "#56B4E9", "#C9A66B", "#8C564B", "#7F7F7F")
SAND, DEEP, STONE = "#F3E9D2", "#9DB8C7", "#6B6259"
SHOWN_SCHOOLS, SHOWN_MINDS, SHOWN_PATHS = 6, 4, 300
RECENT_S = 20.0  # the last part of a path is drawn in full
SMOOTH_S = 2.0  # over which the lines of schools are smoothed


def plot(record: Record, folder: Path, check: Callable[[], None] = lambda: None) -> list[Path]:
    """Write the plots of a record into `folder`, all or none; returns the files.

    A record without schools gets no plot of them. `check`, which may raise, is called between two
    plots.
    """
    pages = {
        name: partial(draw, record=record)
        for name, draw in RECORD_PLOTS.items()
        if draw is not _schools_page or schools(record)
    }
    return write_plots(folder, pages, check)


def _colours(record: Record) -> list[str]:
    more = iter(MORE_COLOURS * len(record.intention_names))
    return [INTENTION_COLOURS.get(name) or next(more) for name in record.intention_names]


def _budget_page(page: Any, record: Record) -> None:
    """Draw the share of time per intention, a bar for each species."""
    from matplotlib.colors import to_rgb

    budget, colours = time_budget(record), _colours(record)
    number = len(budget)
    page.set_size_inches(9, 1.8 + 0.42 * number)
    axis = page.subplots()
    left = np.zeros(number)
    for k, name in enumerate(record.intention_names):
        if budget[:, k].max() < 0.0005:
            continue
        axis.barh(range(number), budget[:, k], left=left, color=colours[k], label=name, height=0.72)
        for row, share in enumerate(budget[:, k]):
            if share >= 0.06:
                axis.text(
                    left[row] + share / 2, row, f"{share:.0%}", ha="center", va="center",
                    fontsize=8, color="white" if np.mean(to_rgb(colours[k])) < DARK else "0.15",
                )  # fmt: skip
        left += budget[:, k]
    counts = [int((record.species == k).sum()) for k in range(number)]
    labels = [f"{name} ({n})" for name, n in zip(record.species_names, counts, strict=True)]
    axis.set_yticks(range(number), labels)
    axis.invert_yaxis()
    axis.set(xlim=(0, 1), xlabel="share of time")
    axis.xaxis.set_major_formatter("{x:.0%}")
    axis.tick_params(axis="y", length=0)
    axis.spines["left"].set_visible(False)
    page.suptitle(f"Time budget, {_span(record)}", x=0.01, ha="left", fontsize=11)
    page.legend(loc="outside lower center", ncols=8)


def _span(record: Record) -> str:
    seconds = len(record.time) * record.tick_s
    return f"{seconds / 60:.1f} minutes" if seconds >= 120 else f"{seconds:.0f} s"


def _schools_page(page: Any, record: Record) -> None:
    """Draw polarisation, nearest-neighbour distance and largest connected part over time."""
    largest = sorted(schools(record), key=lambda s: -int(s.members.max()))[:SHOWN_SCHOOLS]
    page.set_size_inches(10, 6.2)
    top, middle, bottom = page.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
    for school, colour in zip(largest, LINES, strict=False):
        species = record.species_names[record.species[school.leader]]
        label = f"{int(school.members.max())} {species}"
        for axis, values in ((top, school.polarisation), (middle, school.nearest)):
            axis.plot(school.time, values, color=colour, alpha=0.22, linewidth=0.7)
            shown = np.where(school.cruises, values, np.nan)
            axis.plot(school.time, _smooth(shown), color=colour, linewidth=1.6, label=label)
        bottom.plot(school.time, school.together, color=colour, linewidth=1.2)
    top.axhline(0.8, color="0.6", linestyle="--", linewidth=0.8)
    top.set(ylim=(0, 1.02), ylabel="polarisation")
    top.set_title("Length of the mean heading: 1 if all are parallel")
    middle.axhspan(0.6, 1.6, color="0.93", zorder=0)
    middle.set(ylim=(0, 3), ylabel="body lengths")
    middle.set_title("Distance to the nearest companion (median)")
    bottom.axhline(WHOLE, color="0.6", linestyle="--", linewidth=0.8)
    bottom.set(ylim=(0, 1.05), xlim=(0, record.time[-1]), xlabel="time, s", ylabel="share")
    bottom.set_title(f"Largest connected part (within {LINK_BL:g} body lengths)")
    page.legend(
        *top.get_legend_handles_labels(), loc="outside upper right", ncols=min(3, len(largest))
    )
    page.suptitle("Schools; bold while they cruise", x=0.01, ha="left", fontsize=11)


def _smooth(values: Array) -> Array:
    """Compute a running mean that keeps gaps."""
    width = max(round(SMOOTH_S / SAMPLE_S), 1)
    there = np.isfinite(values)
    kernel = np.ones(min(width, len(values)))
    total = np.convolve(np.where(there, values, 0.0), kernel, "same")
    count = np.convolve(there, kernel, "same")
    return np.where(there, total / np.maximum(count, 1), np.nan)


def _minds_page(page: Any, record: Record) -> None:
    """Draw hunger, libido and fear of some fishes, each above a strip of its intentions."""
    from matplotlib.colors import ListedColormap

    chosen = _eventful(record)
    colours = _colours(record)
    page.set_size_inches(10, 0.9 + 1.75 * len(chosen))
    axes = page.subplots(
        2 * len(chosen), 1, sharex=True, squeeze=False, height_ratios=(5, 1) * len(chosen)
    )[:, 0]
    step = max(len(record.time) // 3000, 1)
    for k, fish in enumerate(chosen):
        lines, strip = axes[2 * k], axes[2 * k + 1]
        alive = record.alive[::step, fish]
        for state, name in enumerate(record.mental_state_names):
            values = np.where(alive, record.mental_state[::step, fish, state], np.nan)
            lines.plot(
                record.time[::step], values, color=MENTAL_COLOURS[state], label=name, linewidth=1.1
            )
        eaten = record.time[meals(record)[:, fish]]
        lines.plot(eaten, np.full(len(eaten), 1.06), "|", color="0.25", markersize=5, label="meal")
        lines.set(ylim=(-0.02, 1.12), yticks=(0, 0.5, 1))
        lines.set_title(f"{record.species_names[record.species[fish]]}, fish {fish}")
        doing = np.where(alive, record.intention[::step, fish].astype(float), np.nan)
        strip.imshow(
            doing[None], aspect="auto", interpolation="nearest", cmap=ListedColormap(colours),
            vmin=-0.5, vmax=len(colours) - 0.5,
            extent=(record.time[0] - record.tick_s, record.time[-1], 0, 1),
        )  # fmt: skip
        strip.set(yticks=[])
        strip.spines[:].set_visible(False)
    axes[-1].set(xlabel="time, s")
    done = [code for code in np.unique(record.intention[:, chosen]) if code < len(colours)]
    from matplotlib.patches import Patch

    handles, labels = axes[0].get_legend_handles_labels()
    handles += [Patch(color=colours[code]) for code in done]
    labels += [record.intention_names[code] for code in done]
    page.legend(handles, labels, loc="outside lower center", ncols=8)
    page.suptitle("Minds", x=0.01, ha="left", fontsize=11)


def _eventful(record: Record) -> list[int]:
    """Choose the fishes whose minds change most, of different species if possible."""
    change = record.mental_state.std(axis=0).sum(axis=1)
    variety = np.array([len(np.unique(one)) for one in record.intention.T])
    by_interest = np.argsort(-(change + 0.15 * variety), kind="stable")
    chosen: list[int] = []
    for fish in by_interest:
        if record.species[fish] not in record.species[chosen]:
            chosen.append(int(fish))
    chosen += [int(fish) for fish in by_interest if fish not in chosen]
    return sorted(chosen[:SHOWN_MINDS])


def _paths_page(page: Any, record: Record) -> None:
    """Draw the paths of the fishes from above, over the seabed and its obstacles."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.patches import Circle, Ellipse, Rectangle

    page.set_size_inches(8.6, 7.4)
    axis = page.subplots()
    across = np.linspace(-record.half_width_cm, record.half_width_cm, len(record.heights))
    inside = np.hypot(across[:, None], across) < 1.05 * record.radius_cm
    seabed = np.where(inside, record.heights, np.nan)
    low, high = np.nanmin(seabed) / 100, np.nanmax(seabed) / 100
    shade = axis.contourf(
        across / 100, across / 100, record.heights / 100, extend="both", zorder=0,
        levels=np.linspace(low, max(high, low + 0.1), 13),
        cmap=LinearSegmentedColormap.from_list("seabed", [DEEP, SAND]),
    )  # fmt: skip
    wall = Circle((0, 0), record.radius_cm / 100, fill=False, color="0.2", linewidth=1.2)
    tank = tank_of(record.pillars)
    if record.period[0]:
        tank = (
            float(record.period[0]),
            float(record.period[1]),
        )  # drawn alike; paths go on beyond its sides
    else:
        axis.add_patch(wall)
        shade.set_clip_path(wall)
    if tank:
        long, wide = tank[0] / 100, tank[1] / 100
        glass = Rectangle(
            (-long / 2, -wide / 2), long, wide, fill=False, color="0.2", linewidth=1.2, zorder=3
        )
        axis.add_patch(glass)
    for x, y, radius, _ in record.pillars[~is_wall(record.pillars)] / 100:
        axis.add_patch(Circle((x, y), radius, color=STONE, zorder=4))
    for rock in record.rocks:
        x, y, a, b = rock[[0, 1, 3, 4]] / 100
        axis.add_patch(
            Ellipse((x, y), 2 * a, 2 * b, angle=np.degrees(rock[6]), color=STONE, alpha=0.6,
                    zorder=2)
        )  # fmt: skip
    every = max(round(SAMPLE_S / record.tick_s), 1)
    recent = round(RECENT_S / record.tick_s)
    fishes = np.unique(np.linspace(0, len(record.species) - 1, SHOWN_PATHS).round().astype(int))
    for k, name in enumerate(record.species_names):
        colour = LINES[k % len(LINES)]
        those = fishes[record.species[fishes] == k]
        for fish in those:
            way = np.where(record.alive[:, fish, None], record.position[:, fish, :2] / 100, np.nan)
            axis.plot(*way[::every].T, color=colour, linewidth=0.5, alpha=0.3, zorder=3)
            axis.plot(*way[-recent::every].T, color=colour, linewidth=1.1, alpha=0.9, zorder=5)
        if len(those):
            last = np.where(record.alive[-1, those, None], record.position[-1, those, :2], np.nan)
            axis.plot(*last.T / 100, ".", color=colour, markersize=5, label=name, zorder=6)
    (left, right), (low, high) = _frame(record)
    axis.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x, m", ylabel="y, m")
    axis.spines[:].set_visible(False)
    page.colorbar(shade, ax=axis, label="seabed, m", format="%.1f", shrink=0.5, aspect=25)
    page.legend(loc="outside lower center", ncols=min(4, len(record.species_names)))
    page.suptitle(
        f"Paths from above, {_span(record)}; the last {RECENT_S:g} s in full", x=0.01, ha="left",
        fontsize=11,
    )  # fmt: skip


def _frame(record: Record) -> tuple[Array, Array]:
    """Compute limits in x and y of a square around all paths, m; at most those of the whole sea."""
    whole = 1.03 * record.radius_cm / 100
    places = record.position[record.alive][:, :2] / 100
    low, high = places.min(axis=0), places.max(axis=0)
    half = 0.6 * float((high - low).max()) + 1.0
    if half >= 0.8 * whole and not record.period[0]:
        return np.array([-whole, whole]), np.array([-whole, whole])
    x, y = 0.5 * (low + high)
    return np.array([x - half, x + half]), np.array([y - half, y + half])


def _clearance_page(page: Any, record: Record) -> None:
    """Draw a histogram of the clearance from bounds and obstacles."""
    clearance, which = clearances(record)
    page.set_size_inches(9, 4)
    axis = page.subplots()
    there = np.isfinite(clearance)
    most = float(np.percentile(clearance[there], 99.5)) if there.any() else 1.0
    least = min(float(clearance[there].min()), 0.0) if there.any() else 0.0
    width = max((most - least) / 60, 0.5)
    bins = np.arange(np.floor(least / width) * width, most + width, width)
    parts = [clearance[there & (which == k)] for k in range(len(BARRIERS))]
    shown = [k for k, part in enumerate(parts) if len(part)]
    axis.hist(
        [parts[k] for k in shown], bins=bins, stacked=True, log=True,
        color=[BARRIER_COLOURS[k] for k in shown], label=[BARRIERS[k] for k in shown],
    )  # fmt: skip
    axis.axvline(0, color="#D55E00", linewidth=1.2)
    axis.set(xlabel="least clearance of snout, middle and tail, cm")
    axis.set_ylabel("fish-ticks")
    inside = int((clearance < 0).sum())
    axis.set_title(
        f"Clearance from bounds and obstacles: {inside:,} of {there.sum():,} fish-ticks below 0"
    )
    axis.legend(title="nearest")


RECORD_PLOTS = {
    "time_budget.png": _budget_page,
    "minds.png": _minds_page,
    "paths.png": _paths_page,
    "clearance.png": _clearance_page,
    "schools.png": _schools_page,
}
