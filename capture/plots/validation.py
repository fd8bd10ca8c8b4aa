"""Plot repertoires beside measured fishes: waves, speeds and Strouhal numbers."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from capture.inspection.drag import SWIMMING_DRAG, TURBULENT, VISCOSITY_CM2_S, strouhal_of_drag
from capture.inspection.kinematics import published_limits
from capture.inspection.validation import BAINBRIDGE_HZ, FULL_TEMPO, Validated, bainbridge
from subsea.base.plot_files import Draw

COLUMNS = 5
LEAST_TEMPO = 0.4
GENERIC = 0.4 / 0.2**2  # wetted area over squared tail span of a generic fish
GENERIC_SPEED = 2.0  # L/s
PUBLISHED, OURS = "#D55E00", "#0072B2"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7F3C8D", "#8C564B",
           "#17324D", "#A5AA99")  # fmt: skip


def swimming_plots(found: Sequence[Validated]) -> Mapping[str, Draw]:
    """The plots by name of their file (`SWIMMING_PLOTS`)."""
    return {name: partial(draw, found=found) for name, draw in SWIMMING_PLOTS.items()}


def _waves(page: Any, found: Sequence[Validated]) -> None:
    """Envelope of each species over the published one of its kind."""
    rows = -(-len(found) // COLUMNS)
    page.set_size_inches(12, 2.4 * rows)
    grid = page.subplots(rows, COLUMNS, squeeze=False, sharex=True, sharey=True).ravel()
    at = np.linspace(0.0, 1.0, 50)
    for axis, one in zip(grid, found, strict=False):
        if one.facts.wave != "none":
            low, high = published_limits(one.facts.wave, at)
            axis.plot(at, low, color=PUBLISHED, label="published")
            axis.fill_between(at, low, high, color=PUBLISHED, alpha=0.3)
        for swim in one.swims:
            shade = 1.0 if swim.name == "swim_fast" else 0.35
            axis.plot(swim.wave.stations, swim.wave.envelope, "o-", ms=3, color=OURS, alpha=shade)
        fast = next(swim for swim in one.swims if swim.name == "swim_fast")
        axis.set_title(f"{_words(one)}, λ {fast.wave.wavelength:.2f} L")
    for axis in grid[len(found) :]:
        axis.remove()
    for axis in grid[:COLUMNS]:
        axis.set_ylabel("half amplitude, L")
        break
    page.supxlabel("behind the snout, L (line: published; points: ours, fast swim in full colour)")


def _speeds(page: Any, found: Sequence[Validated]) -> None:
    """Speed over beat frequency with Bainbridge's line, and speeds beside measured ranges."""
    page.set_size_inches(12, 4.6)
    beats, bars = page.subplots(1, 2)
    top = max(FULL_TEMPO * one.swims[-1].frequency for one in found)
    line = np.linspace(BAINBRIDGE_HZ, max(top, 2 * BAINBRIDGE_HZ), 2)
    beats.plot(
        line,
        [bainbridge(float(f)) for f in line],
        color="0.3",
        linestyle="--",
        label="Bainbridge 1958",
    )
    for one, colour in zip(found, COLOURS * len(found), strict=False):
        fast = one.swims[-1]
        tempo = np.array([LEAST_TEMPO, FULL_TEMPO])
        beats.plot(tempo * fast.frequency, tempo * fast.speed, color=colour, alpha=0.5)
        beats.plot([swim.frequency for swim in one.swims], [swim.speed for swim in one.swims], "o",
                   ms=4, color=colour, label=_words(one))  # fmt: skip
    beats.set(xlabel="beats a second, of an adult", ylabel="speed, L/s")
    beats.legend()
    for k, one in enumerate(found):
        for place, colour, name in ((0.2, "#56B4E9", "slow"), (0.0, "#009E73", "cruise"),
                                    (-0.2, "#E69F00", "burst")):  # fmt: skip
            bars.plot(getattr(one.facts, name).range, [k + place] * 2, color=colour, linewidth=4)
        speeds = {swim.name: swim.speed for swim in one.swims}
        last = FULL_TEMPO * one.swims[-1].speed
        bars.plot([speeds["swim_slow"], speeds["swim_fast"], last], [k + 0.2, k, k - 0.2], "k.")
    bars.set_yticks(range(len(found)), [_words(one) for one in found])
    bars.set(xlabel="speed, L/s (points: ours; bars: measured slow, cruise, burst)", xscale="log")


def _strouhal(page: Any, found: Sequence[Validated]) -> None:
    """Strouhal number over size."""
    page.set_size_inches(7, 4.6)
    axis = page.subplots()
    length = np.geomspace(3.0, 400.0, 100)
    reynolds = GENERIC_SPEED * length**2 / VISCOSITY_CM2_S
    laminar, turbulent = 1.328 * reynolds**-0.5, 0.074 * reynolds**-0.2
    friction = np.where(reynolds < TURBULENT, laminar, turbulent)
    line = [strouhal_of_drag(SWIMMING_DRAG * drag, GENERIC) for drag in friction]
    axis.axhspan(0.2, 0.4, color="0.9", label="cruising animals (Taylor et al. 2003)")
    axis.plot(length, line, color="0.3", linestyle="--", label="estimate for a generic fish")
    for one, colour in zip(found, COLOURS * len(found), strict=False):
        values = [swim.strouhal for swim in one.swims]
        axis.plot([one.adult_cm] * len(values), values, "o-", color=colour, label=_words(one), ms=4)
        axis.plot(one.adult_cm, one.expected, "x", color=colour)
    axis.set(xlabel="length, cm (×: estimate for this body)", ylabel="Strouhal number",
             xscale="log", ylim=(0, 1.2))  # fmt: skip
    axis.legend(ncols=2)


def _words(one: Validated) -> str:
    return one.species.replace("_", " ")


SWIMMING_PLOTS = {
    "swimming-waves.png": _waves,
    "swimming-speeds.png": _speeds,
    "swimming-strouhal.png": _strouhal,
}
