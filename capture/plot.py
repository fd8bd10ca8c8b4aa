"""Pictures of a repertoire: what the motion looks like, for a person to judge."""

from pathlib import Path
from typing import Any

import numpy as np

from capture.quality import replay
from subsea.biomechanics.body import LOWER_TAIL, UPPER_TAIL, Floats
from subsea.errors import UserError
from subsea.repertoire import Repertoire, Segment

STRIP_FRAMES = 8
CYCLES = 3
INCHES = 1.5
LEFT_EDGE, RIGHT_EDGE = (0, 1, 5, 9, 13, 17, 21), (21, 18, 14, 10, 6, 2, 0)
"""Nodes down the left and up the right flank, seen from above."""


def plot_repertoire(repertoire: Repertoire, folder: Path) -> list[Path]:
    """Write a film strip of every segment, all paths and all tail beats; return the files.

    Raises UserError without matplotlib or where the folder cannot be written.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as fault:
        raise UserError("plots need matplotlib: install subsea[plot]") from fault
    pictures = {
        f"strip_{name}": _strip(Figure, name, segment)
        for name, segment in repertoire.segments.items()
    }
    pictures["paths"] = _paths(Figure, repertoire)
    pictures["tail_beats"] = _tail_beats(Figure, repertoire)
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for stem, figure in pictures.items():
            path = folder / f"{repertoire.species}_{stem}.png"
            figure.savefig(path, dpi=80, bbox_inches="tight", metadata={"Software": None})
            written.append(path)
    except OSError as fault:
        raise UserError(f"{folder}: cannot write ({fault.strerror or fault})") from fault
    return written


def _world(segment: Segment) -> Floats:
    """World nodes (T, 23, 3) of a segment that starts on the axes of the world."""
    cycles = CYCLES if segment.cyclic else 1
    return replay(segment, np.zeros(3), np.eye(3), cycles)


def _strip(figure: type, name: str, segment: Segment) -> Any:
    """The body from above in some frames of a segment, one beside another, turning as it turns."""
    frames = replay(segment, np.zeros(3), np.eye(3), 1)
    chosen = frames[np.linspace(0, len(frames) - 1, STRIP_FRAMES).round().astype(int)]
    picture = figure(figsize=(INCHES * STRIP_FRAMES, 2.4 * INCHES))
    axes = picture.subplots(1, STRIP_FRAMES, sharex=True, sharey=True)
    for place, (axis, nodes) in enumerate(zip(axes, chosen, strict=True)):
        nodes = nodes - nodes[5:9].mean(axis=0)
        # Seen from above with the nose up: right is to the right.
        axis.fill(nodes[LEFT_EDGE + RIGHT_EDGE, 2], nodes[LEFT_EDGE + RIGHT_EDGE, 0], "0.75")
        spine = _spine(nodes)
        axis.plot(spine[:, 2], spine[:, 0], "k", linewidth=1)
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_title(str(round(place * (len(frames) - 1) / (STRIP_FRAMES - 1))), fontsize=8)
    picture.suptitle(f"{name}: top view by frame", fontsize=9)
    return picture


def _spine(nodes: Floats) -> Floats:
    """Nose, centres of the five rings and middle of the tail (7, 3)."""
    rings = nodes[1:21].reshape(5, 4, 3).mean(axis=1)
    tail = nodes[[UPPER_TAIL, LOWER_TAIL]].mean(axis=0)
    return np.concatenate([nodes[:1], rings, tail[None]])


def _paths(figure: type, repertoire: Repertoire) -> Any:
    """The way of nose, centre and tail in every segment, seen from above."""
    names = list(repertoire.segments)
    picture = figure(figsize=(2 * INCHES * len(names), 3 * INCHES))
    for axis, name in zip(picture.subplots(1, len(names)), names, strict=True):
        frames = _world(repertoire.segments[name])
        spines = np.array([_spine(nodes) for nodes in frames])
        for place, label in ((0, "nose"), (2, "centre"), (6, "tail")):
            axis.plot(spines[:, place, 2], spines[:, place, 0], linewidth=1, label=label)
        axis.set_aspect("equal", adjustable="datalim")
        axis.set_title(name, fontsize=8)
        axis.tick_params(labelsize=6)
    picture.axes[0].legend(fontsize=6)
    picture.axes[0].set_ylabel("cm", fontsize=7)
    return picture


def _tail_beats(figure: type, repertoire: Repertoire) -> Any:
    """How far the tail stands to the right of the body axis, over time."""
    picture = figure(figsize=(6 * INCHES, 3 * INCHES))
    axis = picture.subplots()
    for name, segment in repertoire.segments.items():
        cycles = CYCLES if segment.cyclic else 1
        tail = np.tile(segment.nodes[:, [UPPER_TAIL, LOWER_TAIL], 2].mean(axis=1), cycles)
        seconds = np.arange(1, len(tail) + 1) * repertoire.tick_s
        axis.plot(seconds, tail, linewidth=1, label=name)
    axis.set_xlabel("s")
    axis.set_ylabel("tail to the right, cm")
    axis.legend(fontsize=6)
    return picture
