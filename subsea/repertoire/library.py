"""All repertoires of a dive in flat arrays, for kernels and the GPU."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.fish.skinning import Coupling, place
from subsea.kernels.struct_ref import Kind, by_pointer
from subsea.repertoire.blending import (
    LEVELS,
    TIGHTEST,
    Blend,
    TurningWay,
    blend_turns,
    course_of,
)
from subsea.repertoire.schema import (
    BASIC_SEGMENTS,
    FAMILIES,
    SEGMENTS,
    SUBSTITUTES,
    Repertoire,
    Segment,
    Transitions,
)
from subsea.repertoire.transitions import plan_transitions


class LibraryKind(Kind):
    """The compiler's type of `Library`."""


@by_pointer(LibraryKind)
class Library(NamedTuple):
    """Rows are frames of all segments of all species in sequence (R rows, S species).

    There are n segments, as in SEGMENTS. One that was not recorded has the rows of its substitute.
    Behind the recorded rows lie those that blend straight swims with their turns (FAMILIES).
    A world with k simulated fishes appends 2 k rows for their poses.
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
    pace: Array  # (S, n, 2) float32, cm per frame at the beginning and end of each segment
    turn: Array  # (S, n) float32, rad, change of heading over each segment, left positive
    follow: Ints  # (R,) int32, the next row; the last one of an acyclic segment is its own
    straight: Ints  # (R,) int32, of a row of a blended turn the swim's at equal phase, else itself
    level: Ints  # (R,) int32, share of a blended turn in LEVELS parts, left positive
    veer: Ints  # (S, n) int32, first blended row of each turn, -1 for none
    slowing: Array  # (S, n) float32, share of its speed that a fish loses per frame, undriven
    sway: Array  # (R,) float32, rad, heading of B beyond the mean course: the beat of the head
    bank: Array  # (R,) float32, rad, roll of the recorded fish
    facing: Array  # (R,) float32, rad, of the head from its way in a bend, left positive
    coupling: Coupling  # arrays (S, 426, …): control points from nodes
    recorded_length: Array  # (S,) float32, cm
    bounding_radius: Array  # (S,) float32, body lengths


LIVE_TABLES = ("rotation", "translation", "nodes", "sway")
"""Tables whose last rows are those of the simulated fishes."""


class _Species(NamedTuple):
    """The segments of one species, and the rows of the library where they lie."""

    segments: list[Segment]
    played: list[int]  # place of each of SEGMENTS, or of its substitute, among `segments`
    starts: Ints  # first row of each segment, and the end of the last
    plan: Transitions
    blends: dict[str, Blend]  # by the name of the straight swim

    def begin(self, name: str) -> int:
        """The first row of a segment."""
        return int(self.starts[self.played[SEGMENTS.index(name)]])

    courses: list[TurningWay]


class _Rows(NamedTuple):
    """The tables of the library that have a row for each frame."""

    rotation: Array
    translation: Array
    nodes: Array
    points: Array
    entry: Ints
    glide: Ints
    leave: NDArray[np.bool_]
    follow: Ints
    straight: Ints
    level: Ints
    sway: Array
    bank: Array
    facing: Array


def pack(repertoires: Sequence[Repertoire], couplings: Sequence[Coupling]) -> Library:
    """Pack repertoires into flat arrays, without rows of simulated fishes.

    Missing control points are computed from the nodes; a missing basic segment is a UserError.
    """
    species: list[_Species] = []
    for repertoire in repertoires:
        species.append(_species(repertoire, int(species[-1].starts[-1]) if species else 0))
    parts = [_recorded(one, skin) for one, skin in zip(species, couplings, strict=True)]
    row = sum(len(part.entry) for part in parts)
    veer = np.full((len(species), len(SEGMENTS)), -1, np.int32)
    for k, one in enumerate(species):
        for straight, blend in one.blends.items():
            parts.append(_blended(one, straight, parts[k], couplings[k], row))
            for name in FAMILIES[straight]:
                veer[k, SEGMENTS.index(name)] = row
                row += len(blend.nodes) // 2
    rows = _Rows(*(_table(column) for column in zip(*parts, strict=True)))
    return Library(
        rotation=rows.rotation,
        translation=rows.translation,
        nodes=rows.nodes,
        control_points=rows.points,
        has=np.array([[n in r.segments for n in SEGMENTS] for r in repertoires], np.bool_),
        first=np.array([one.starts[one.played] for one in species], np.int32),
        length=np.array([np.diff(one.starts)[one.played] for one in species], np.int32),
        cyclic=np.array([[one.segments[k].cyclic for k in one.played] for one in species]),
        speed=np.array(
            [[one.segments[k].speed_cm_s for k in one.played] for one in species], np.float32
        ),
        entry=rows.entry,
        glide=rows.glide,
        leave=rows.leave,
        pace=np.array([[one.courses[k].pace for k in one.played] for one in species], np.float32),
        turn=np.array([[one.courses[k].turn for k in one.played] for one in species], np.float32),
        follow=rows.follow,
        straight=rows.straight,
        level=rows.level,
        veer=veer,
        slowing=np.array(
            [[one.segments[k].slowing for k in one.played] for one in species], np.float32
        ),
        sway=rows.sway,
        bank=rows.bank,
        facing=rows.facing,
        coupling=Coupling(*(np.stack(part) for part in zip(*couplings, strict=True))),
        recorded_length=np.array([r.body_length_cm for r in repertoires], np.float32),
        bounding_radius=np.array(
            [max(s.bounding_radius_bl for s in r.segments.values()) for r in repertoires],
            np.float32,
        ),
    )


def _species(repertoire: Repertoire, row: int) -> _Species:
    """Lay out a species from `row` on; a missing basic segment is a UserError."""
    missing = [name for name in BASIC_SEGMENTS if name not in repertoire.segments]
    if missing:
        raise UserError(f"repertoire of {repertoire.species}: no segment {missing[0]!r}")
    names = repertoire.recorded_names()
    segments = [repertoire.segments[name] for name in names]
    return _Species(
        segments,
        [names.index(n if n in names else SUBSTITUTES[n]) for n in SEGMENTS],
        row + np.cumsum([0] + [len(s.nodes) for s in segments]),
        repertoire.transitions or plan_transitions(segments),
        {
            name: blend
            for name in FAMILIES
            if (blend := blend_turns(repertoire.segments, name)) is not None
        },
        [course_of(segment) for segment in segments],
    )


def _recorded(one: _Species, coupling: Coupling) -> _Rows:
    """The recorded rows of a species."""
    segments, first, end = one.segments, int(one.starts[0]), int(one.starts[-1])
    follow, straight, level = (
        np.arange(first, end) + 1,
        np.arange(first, end),
        np.zeros(end - first, np.int32),
    )
    for segment, begin, after in zip(segments, one.starts, one.starts[1:], strict=False):
        follow[after - 1 - first] = begin if segment.cyclic else after - 1
    for swim, blend in one.blends.items():
        for turn, phase, full in zip(FAMILIES[swim], blend.phase, (LEVELS, -LEVELS), strict=True):
            begin = one.begin(turn) - first
            straight[begin : begin + len(phase)] = one.begin(swim) + phase
            level[begin : begin + len(phase)] = full
    return _Rows(
        np.concatenate([s.increment_rotation for s in segments]),
        np.concatenate([s.increment_translation for s in segments]),
        np.concatenate([s.nodes for s in segments]),
        np.concatenate(
            [
                place(coupling, s.nodes) if s.control_points is None else s.control_points
                for s in segments
            ]
        ),
        first + one.plan.entry[:, one.played],
        one.plan.frames[:, one.played],
        one.plan.leave[:, one.played],
        follow, straight, level,
        np.concatenate([course.sway for course in one.courses]),
        np.concatenate([course.bank for course in one.courses]),
        np.zeros(len(follow)),
    )  # fmt: skip


def _blended(one: _Species, straight: str, recorded: _Rows, coupling: Coupling, here: int) -> _Rows:
    """The rows between a straight swim of a species and its turns, from row `here` on.

    They are left as the swim at equal phase.
    """
    blend, first = one.blends[straight], int(one.starts[0])
    beat = len(blend.phase[0])
    swim = one.begin(straight) + np.arange(beat)
    tables = recorded.nodes, recorded.sway, recorded.bank, recorded.facing
    points = np.empty((len(blend.nodes), *recorded.points.shape[1:]), np.float32)
    levels: list[int] = []
    mixes = []
    for side, name in enumerate(FAMILIES[straight]):
        turn = np.empty(beat, np.int64)
        turn[blend.phase[side]] = one.begin(name) + np.arange(beat)
        recorded.facing[turn - first] = blend.facing[side]
        ends = [(table[swim - first], table[turn - first]) for table in (*tables, recorded.points)]
        for k in range(1, TIGHTEST + 1):
            *mix, skin = ((1.0 - k / LEVELS) * a + k / LEVELS * b for a, b in ends)
            # The skin follows the nodes, which are mixed by angles. All is done level by level, as
            # all levels together do not fit into the processor's cache.
            at = slice(len(levels) * beat, (len(levels) + 1) * beat)
            skin += coupling.weights @ (blend.nodes[at] - mix[0])
            points[at] = skin
            mixes.append(mix[1:])
            levels.append(k if side == 0 else -k)
    sway, bank, facing = (np.concatenate(parts) for parts in zip(*mixes, strict=True))
    rows, phase = (np.tile(one, 2 * TIGHTEST) for one in (swim - first, np.arange(beat)))
    place = here + np.arange(len(rows))
    return _Rows(
        blend.rotation, blend.translation, blend.nodes, points,
        recorded.entry[rows], recorded.glide[rows], recorded.leave[rows],
        place - phase + (phase + 1) % beat, np.tile(swim, 2 * TIGHTEST), np.repeat(levels, beat),
        sway, bank, facing,
    )  # fmt: skip


def _table(parts: Sequence[Any]) -> Any:
    """Rows of all parts in sequence, in single precision. The largest table has 60 MB."""
    kept = {"f": np.float32, "i": np.int32, "b": np.bool_}[parts[0].dtype.kind]
    return np.concatenate(parts, dtype=kept, casting="same_kind")
