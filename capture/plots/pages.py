"""Plot a repertoire: each segment, the whole, and the whole beside measured fishes."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from capture.inspection.gait import entries, turned
from capture.inspection.kinematics import published_limits
from capture.inspection.report import (
    SWIMMING_DRAG,
    TURBULENT,
    VISCOSITY_CM2_S,
    strouhal_of_drag,
)
from capture.inspection.validation import BAINBRIDGE_HZ, FULL_TEMPO, Validated, bainbridge
from capture.plots import panels
from capture.recording.record import (
    Motion,
    motion_from_provenance,
    spine_from_provenance,
)
from capture.recording.segment import motion_of_segment
from subsea.base import report_files as plot_files
from subsea.base.errors import UserError
from subsea.base.report_files import Draw, write_plots
from subsea.biomechanics.body import Floats, build_body
from subsea.biomechanics.simulation import BodyState
from subsea.biomechanics.trial import deformation, speed_map
from subsea.repertoire import Repertoire, Segment
from subsea.repertoire.segments import run_trial

WIDTH = 12.0
STYLE = {
    **plot_files.STYLE,
    "font.size": 11,
    "axes.titlesize": 12,
    "axes.titlelocation": "center",
    "legend.fontsize": 10,
}
ANGLES = np.arange(15.0, 91.0, 15.0)


def plots_in(folder: Path, repertoire: Repertoire) -> list[Path]:
    """The files that `plot_repertoire` writes: a page for each segment, then the repertoire's."""
    names = [f"{repertoire.species}_{name}" for name, _ in panels.in_order(repertoire)]
    return [folder / f"{name}.png" for name in [*names, repertoire.species]]


def plot_repertoire(repertoire: Repertoire, folder: Path) -> list[Path]:
    """Write a PNG page for each segment and one for the repertoire; return the files.

    First frames and, of muscle-driven fishes, speed and steering maps are simulated again from
    the provenance; they are left out where it holds no plans. UserError without matplotlib or
    where the folder cannot be written.
    """
    motion = _motion(repertoire)
    pages: dict[str, Draw] = {}
    for name, segment in panels.in_order(repertoire):
        about = repertoire, motion, name, segment
        pages[f"{repertoire.species}_{name}.png"] = partial(_segment_page, about=about)
    pages[f"{repertoire.species}.png"] = partial(
        _repertoire_page, repertoire=repertoire, motion=motion
    )
    return write_plots(folder, pages, style=STYLE)


def _motion(repertoire: Repertoire) -> Motion | None:
    try:
        return motion_from_provenance(repertoire.provenance)
    except msgspec.ValidationError:
        return None


def _first_frame(repertoire: Repertoire, motion: Motion | None, name: str) -> Floats | None:
    """The first deformation (23, 3) of a segment, which its file does not hold."""
    if name == "row_forward":
        return np.asarray(repertoire.rest_nodes, np.float64)
    if motion:
        try:
            frames = run_trial(motion, name).frames
        except UserError:  # recorded by another version
            return None
    else:
        try:
            plans = spine_from_provenance(repertoire.provenance)
        except msgspec.ValidationError:
            return None
        frames = motion_of_segment(*plans, name).nodes
    return np.asarray(deformation(frames[:1])[0])


def _segment_page(page: Any, about: tuple[Repertoire, Motion | None, str, Segment]) -> None:
    repertoire, motion, name, segment = about
    first = _first_frame(repertoire, motion, name)
    tick = repertoire.tick_s
    kind = "one cycle" if segment.cyclic else "not cyclic"
    page.suptitle(
        f"{repertoire.species} · {name} · {len(segment.nodes)} frames of {1000 * tick:g} ms, {kind}"
        f" · turns by {round(segment.turn_deg, 1) + 0.0:+.1f}°"
    )
    right, ahead = panels.strip_limits(segment)
    shown = len(panels.strip_frames(segment))
    strip = 0.9 * WIDTH / shown * np.ptp(ahead) / np.ptp(right)
    page.set_size_inches(WIDTH, strip + 10.2)
    rows = page.subfigures(2, 1, height_ratios=(strip + 0.7, 9.5))
    panels.strip(rows[0].subplots(1, shown, squeeze=False)[0], segment, tick)
    grid = rows[1].subplots(3, 3)
    panels.trajectories(grid[0, 0], grid[0, 1], segment, tick)
    panels.path(grid[0, 2], segment)
    panels.speed(grid[1, 0], segment, repertoire)
    panels.tail_sweep(grid[1, 1], segment, repertoire)
    panels.tail_spectrum(grid[1, 2], segment, repertoire)
    for axis in grid[2]:
        axis.remove()
    bottom = grid[2, 0].get_gridspec()
    panels.envelope(rows[1].add_subplot(bottom[2, :2]), segment, repertoire)
    panels.closure(rows[1].add_subplot(bottom[2, 2]), segment, first)


def _repertoire_page(page: Any, repertoire: Repertoire, motion: Motion | None) -> None:
    page.set_size_inches(WIDTH, 12 if motion else 8)
    page.suptitle(
        f"{repertoire.species} · {repertoire.body_length_cm:g} cm · from {repertoire.source}"
    )
    rows = page.subfigures(2, 1, height_ratios=(1, 2 if motion else 0.9))
    panels.paths(rows[0].subplots(1, len(repertoire.segments), squeeze=False)[0], repertoire)
    grid = rows[1].subplots(2 if motion else 1, 2, squeeze=False)
    panels.speed_bars(grid[0, 0], repertoire)
    panels.tail_beats(grid[0, 1], repertoire)
    if motion is None:
        return
    grid[1, 0].remove()
    grid[1, 1].remove()
    cells = grid[0, 0].get_gridspec()[1, :].subgridspec(1, 3)
    body = build_body(motion.body)
    speeds, turns = rows[1].add_subplot(cells[0]), rows[1].add_subplot(cells[1])
    try:
        panels.speed_control(speeds, speed_map(body, motion.swim), motion.body.length)
    except UserError as fault:
        panels.note(speeds, f"speed by amplitude: {fault}")
    try:
        panels.turned(turns, ANGLES, _turned(motion))
    except UserError as fault:
        panels.note(turns, f"angles of turns: {fault}")
    panels.steering_map(rows[1].add_subplot(cells[2]), motion.turn)


def _turned(motion: Motion) -> Floats:
    """Measured angles (n, phases) of turns by `ANGLES`, entered at several phases.

    NaN where the body loses its shape; UserError for a fish that does not swim steadily.
    """
    body = build_body(motion.body)
    swim, turn = motion.swim, motion.turn

    def angle_of(angle: float, start: tuple[BodyState, float]) -> float:
        try:
            return turned(body, swim, turn, angle, *start)
        except UserError:
            return np.nan

    starts = entries(body, swim, run_trial(motion, "swim_medium").state)
    return np.array([[angle_of(angle, start) for start in starts] for angle in ANGLES])


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
