"""All repertoires of a dive in flat arrays, for kernels and the GPU."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array, Ints
from subsea.core.errors import UserError
from subsea.fish.coupling import Coupling, place
from subsea.repertoire.schema import (
    BASIC_SEGMENTS,
    SEGMENTS,
    SUBSTITUTES,
    Repertoire,
    Transitions,
)
from subsea.repertoire.transitions import plan_transitions


class Library(NamedTuple):
    """Rows are frames of all segments of all species in sequence (R rows, S species).

    There are n segments, as in SEGMENTS. One that was not recorded has the rows of its substitute.
    The first four tables end with 2 k rows for the poses of simulated fishes.
    """

    rotation: Array  # (R + 2 k, 4) float32, increments in body axes
    translation: Array  # (R + 2 k, 3) float32, cm
    nodes: Array  # (R + 2 k, 23, 3) float32, cm, body axes
    control_points: Array  # (R + 2 k, 426, 3) float32, cm, body axes
    has: NDArray[np.bool_]  # (S, n), True for a segment that was recorded
    first: Ints  # (S, n) int32, first row of each segment
    length: Ints  # (S, n) int32, rows of each segment
    cyclic: NDArray[np.bool_]  # (S, n)
    speed: Array  # (S, n) float32, cm/s of the recorded fish
    entry: Ints  # (R, n) int32, row at which a segment is entered from each row ...
    glide: Ints  # (R, n) int32, ... and the number of frames that takes
    leave: NDArray[np.bool_]  # (R, n), True if this row is good for leaving to a segment
    coupling: Coupling  # arrays (S, 426, …): control points from nodes
    recorded_length: Array  # (S,) float32, cm
    bounding_radius: Array  # (S,) float32, body lengths


def pack(
    repertoires: Sequence[Repertoire], couplings: Sequence[Coupling], live: int = 0
) -> Library:
    """Pack repertoires into flat arrays, with rows for `live` simulated fishes.

    Missing control points are computed from the nodes; a missing basic segment is a UserError.
    """
    rotation, translation, nodes, points = [], [], [], []
    plans: list[Transitions] = []
    first, length, cyclic, speed, has = [], [], [], [], []
    row = 0
    for repertoire, coupling in zip(repertoires, couplings, strict=True):
        missing = [name for name in BASIC_SEGMENTS if name not in repertoire.segments]
        if missing:
            raise UserError(f"repertoire of {repertoire.species}: no segment {missing[0]!r}")
        names = repertoire.recorded_names()
        segments = [repertoire.segments[name] for name in names]
        played = [names.index(n if n in names else SUBSTITUTES[n]) for n in SEGMENTS]
        starts = row + np.cumsum([0] + [len(s.nodes) for s in segments])
        row = int(starts[-1])
        first.append(starts[played])
        length.append(np.diff(starts)[played])
        cyclic.append([segments[k].cyclic for k in played])
        speed.append([segments[k].speed_cm_s for k in played])
        has.append([name in names for name in SEGMENTS])
        for segment in segments:
            rotation.append(segment.increment_rotation)
            translation.append(segment.increment_translation)
            nodes.append(segment.nodes)
            points.append(
                place(coupling, segment.nodes)
                if segment.control_points is None
                else segment.control_points
            )
        plan = repertoire.transitions or plan_transitions(segments)
        plans.append(
            Transitions(
                starts[0] + plan.entry[:, played], plan.frames[:, played], plan.leave[:, played]
            )
        )
    return Library(
        rotation=_table(rotation, live),
        translation=_table(translation, live),
        nodes=_table(nodes, live),
        control_points=_table(points, live),
        has=np.array(has, np.bool_),
        first=np.array(first, np.int32),
        length=np.array(length, np.int32),
        cyclic=np.array(cyclic, np.bool_),
        speed=np.array(speed, np.float32),
        entry=np.concatenate([p.entry for p in plans]).astype(np.int32),
        glide=np.concatenate([p.frames for p in plans]).astype(np.int32),
        leave=np.concatenate([p.leave for p in plans]),
        coupling=Coupling(*(np.stack(part) for part in zip(*couplings, strict=True))),
        recorded_length=np.array([r.body_length_cm for r in repertoires], np.float32),
        bounding_radius=np.array(
            [max(s.bounding_radius_bl for s in r.segments.values()) for r in repertoires],
            np.float32,
        ),
    )


def _table(parts: list[Array], live: int) -> Array:
    """Recorded rows in sequence, and two empty rows for each live fish."""
    empty = np.zeros((2 * live, *parts[0].shape[1:]))
    return np.concatenate([*parts, empty]).astype(np.float32)
