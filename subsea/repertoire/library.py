"""All repertoires of a dive in flat arrays, for compiled kernels and for the GPU."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.errors import UserError
from subsea.kinematics.skin import skin_weights
from subsea.repertoire.schema import SEGMENTS, Array, Repertoire

Ints = NDArray[np.integer[Any]]

# How far the tail's velocity counts against its place when a segment is entered: frames.
VELOCITY_WEIGHT_FRAMES = 2.0
# A cyclic segment is left only in this share of its rows, those most like what comes next.
LEAVING_SHARE = 0.3


class Library(NamedTuple):
    """Rows are frames; all segments of all species follow one another (R rows, S species)."""

    rotation: Array  # (R, 4) float32, increments in body axes
    translation: Array  # (R, 3) float32, cm
    nodes: Array  # (R, 23, 3) float32, cm, body axes
    control_points: Array  # (R, 426, 3) float32, cm, body axes
    first: Ints  # (S, 7) int32, first row of each segment
    length: Ints  # (S, 7) int32, rows of each segment
    cyclic: NDArray[np.bool_]  # (S, 7)
    speed: Array  # (S, 7) float32, cm/s of the recorded fish
    turn: Array  # (S, 7) float32, rad, left positive
    entry: Ints  # (R, 7) int32, row at which a segment is best entered from each row
    leave: NDArray[np.bool_]  # (R, 7), whether this row is a good one to leave for a segment
    recorded_length: Array  # (S,) float32, cm
    bounding_radius: Array  # (S,) float32, body lengths


def pack(repertoires: Sequence[Repertoire], rest_points: Sequence[Array]) -> Library:
    """Lay the repertoires out in flat arrays.

    `rest_points` (426, 3) per species serves those whose file carries no control points: they
    are made from the nodes. A repertoire that lacks one of the seven segments is a UserError.
    """
    rotation, translation, nodes, points, entry, leave = [], [], [], [], [], []
    first, length, cyclic, speed, turn = [], [], [], [], []
    row = 0
    for repertoire, rest in zip(repertoires, rest_points, strict=True):
        missing = [name for name in SEGMENTS if name not in repertoire.segments]
        if missing:
            raise UserError(f"repertoire of {repertoire.species}: no segment {missing[0]!r}")
        segments = [repertoire.segments[name] for name in SEGMENTS]
        weights = skin_weights(repertoire.rest_nodes, rest)
        starts = row + np.cumsum([0] + [len(s.nodes) for s in segments])
        row = int(starts[-1])
        first.append(starts[:-1])
        length.append(np.diff(starts))
        cyclic.append([s.cyclic for s in segments])
        speed.append([s.speed_cm_s for s in segments])
        turn.append([np.radians(s.turn_deg) for s in segments])
        for segment in segments:
            rotation.append(segment.increment_rotation)
            translation.append(segment.increment_translation)
            nodes.append(segment.nodes)
            points.append(
                weights @ segment.nodes
                if segment.control_points is None
                else segment.control_points
            )
        entries, leaving = _entries([s.nodes for s in segments], cyclic[-1])
        entry.append(starts[0] + entries)
        leave.append(leaving)
    return Library(
        rotation=np.concatenate(rotation).astype(np.float32),
        translation=np.concatenate(translation).astype(np.float32),
        nodes=np.concatenate(nodes).astype(np.float32),
        control_points=np.concatenate(points).astype(np.float32),
        first=np.array(first, np.int32),
        length=np.array(length, np.int32),
        cyclic=np.array(cyclic, np.bool_),
        speed=np.array(speed, np.float32),
        turn=np.array(turn, np.float32),
        entry=np.concatenate(entry).astype(np.int32),
        leave=np.concatenate(leave),
        recorded_length=np.array([r.body_length_cm for r in repertoires], np.float32),
        bounding_radius=np.array(
            [max(s.bounding_radius_bl for s in r.segments.values()) for r in repertoires],
            np.float32,
        ),
    )


def _entries(segments: list[Array], cyclic: list[bool]) -> tuple[Ints, NDArray[np.bool_]]:
    """Where each segment is entered from each row of a species (r, 7), and is it a good moment.

    A cyclic segment may be entered anywhere: at the row after the one whose pose and motion are
    nearest, so a fish that speeds up goes on with its beat. The others begin at their first row,
    and a fish that is about to turn waits, a few frames, until its beat is where the turn
    begins. Rows count from the species' first row.
    """
    poses = [s.reshape(len(s), -1) for s in segments]
    motion = [
        np.diff(np.concatenate([p[-1:] if loop else p[:1], p]), axis=0)
        for p, loop in zip(poses, cyclic, strict=True)
    ]
    features = [
        np.concatenate([p, VELOCITY_WEIGHT_FRAMES * m], axis=1)
        for p, m in zip(poses, motion, strict=True)
    ]
    rows = np.concatenate(features)
    start = 0
    columns, gaps = [], []
    for target, loop in zip(features, cyclic, strict=True):
        gap = ((rows[:, None, :] - target[None, :, :]) ** 2).sum(axis=2)
        if loop:
            columns.append(start + (np.argmin(gap, axis=1) + 1) % len(target))
            gaps.append(gap.min(axis=1))
        else:
            columns.append(np.full(len(rows), start))
            gaps.append(gap[:, 0])
        start += len(target)
    nearness = np.stack(gaps, axis=1)
    good = np.ones(nearness.shape, np.bool_)
    start = 0
    for own, loop in zip(features, cyclic, strict=True):
        if loop:
            part = slice(start, start + len(own))
            good[part] = nearness[part] <= np.quantile(nearness[part], LEAVING_SHARE, axis=0)
        start += len(own)
    return np.stack(columns, axis=1), good
