"""Plots of `subsea study --validate`: swimming, schools and predation beside measured ranges."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from subsea.base.plot_files import Draw
from subsea.fish.measured import MeasuredSwimming
from subsea.lab.schooling import BEARINGS
from subsea.lab.validation_report import Summary

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
