"""Plot a repertoire: a page for each segment and one for the whole."""

from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from capture.inspection.gait import entries, turned
from capture.plots import panels
from capture.recording.record import (
    Motion,
    motion_from_provenance,
    run_trial,
    spine_from_provenance,
)
from capture.recording.spine_segments import motion_of_segment
from capture.recording.trial import deformation, speed_map
from subsea.base import plot_files
from subsea.base.plot_files import Draw, write_plots
from subsea.biomechanics.body import Floats, build_body
from subsea.repertoire import Repertoire, Segment

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
        frames = run_trial(motion, name).frames
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
    panels.speed_control(
        rows[1].add_subplot(cells[0]), speed_map(body, motion.swim), motion.body.length
    )
    panels.turned(rows[1].add_subplot(cells[1]), ANGLES, _turned(motion))
    panels.steering_map(rows[1].add_subplot(cells[2]), motion.turn)


def _turned(motion: Motion) -> Floats:
    """Measured angles (n, phases) of turns by `ANGLES`, entered at several phases."""
    body = build_body(motion.body)
    swim, turn = motion.swim, motion.turn
    starts = entries(body, swim, run_trial(motion, "swim_medium").state)
    return np.array(
        [[turned(body, swim, turn, angle, *start) for start in starts] for angle in ANGLES]
    )
