"""Every transition of every shipped species is smooth for all nodes."""

from itertools import permutations

import numpy as np
import pytest

from capture.recording.manoeuvres import MOST_JERK_BL
from subsea.fish.species import species_names
from subsea.motor.playback import advance
from subsea.motor.pose import nodes_world
from subsea.repertoire import SEGMENTS
from subsea.state import Fishes, empty

LIMIT = 2.0  # times the largest change of velocity inside the two segments, or ...
SMOOTH_BL = 0.05  # ... body lengths per tick² between swims and gradual turns, and ...
# ... what the recorder allows inside a manoeuvre, from or to one.


@pytest.fixture(scope="module", params=species_names())
def shipped(request, shipped_library):
    """The library of one species, the largest change inside each segment, and the length in cm."""
    repertoire, _, library = shipped_library(request.param)
    usual = []
    for code in range(len(SEGMENTS)):
        length = library.length[0, code]
        path, _ = _play(library, code, 1, 2 * length if library.cyclic[0, code] else length - 2)
        usual.append(_changes(path).max())
    return library, np.array(usual), repertoire.body_length_cm


def _play(library, code, phase, ticks, wanted=None, after=np.inf):
    """World nodes and segments of a fish that starts at row `phase` of a segment.

    After the change to the wanted segment the fish is followed for `after` ticks more.
    """
    fishes = empty(Fishes, n=1)
    first, length = library.first[0, code], library.length[0, code]
    fishes.segment[:] = fishes.wanted_segment[:] = code
    fishes.length[:] = library.recorded_length[0]
    fishes.row_a[0] = first + (phase - 1) % length
    fishes.row_b[0] = first + phase
    path, segments = [nodes_world(fishes, library, 0)], [code]
    while len(path) <= ticks and after > 0:
        if wanted is not None:
            fishes.wanted_segment[:] = wanted
        o, q = advance(fishes, library, 0)
        fishes.position[0], fishes.orientation[0] = o, q / np.linalg.norm(q)
        path.append(nodes_world(fishes, library, 0))
        segments.append(int(fishes.segment[0]))
        after -= segments[-1] == wanted
    return np.array(path), segments


def _changes(path):
    """The largest change of any node's velocity at each frame, cm per tick²."""
    return np.linalg.norm(np.diff(path, 2, axis=0), axis=2).max(axis=1)


def test_no_node_is_jerked(shipped):
    library, usual, body_length = shipped
    for before, after in permutations(np.flatnonzero(library.has[0]), 2):
        length = library.length[0, before]
        phases = range(0, length, 2) if library.cyclic[0, before] else [length - 6]
        for phase in phases:
            path, segments = _play(library, before, phase, 2 * length + 45, after, 16)
            switched = segments.index(after)
            window = slice(max(switched - 3, 0), switched + 14)
            swims = library.cyclic[0, before] and library.cyclic[0, after]
            least = (SMOOTH_BL if swims else MOST_JERK_BL) * body_length
            limit = max(LIMIT * usual[before], LIMIT * usual[after], least)
            where = f"{SEGMENTS[before]} to {SEGMENTS[after]}, phase {phase}"
            assert _changes(path)[window].max() <= limit, where


def test_a_turn_of_more_than_its_angle_is_two_turns(shipped):
    """A sharp turn that is still wanted at its end continues without a jerk."""
    library, usual, body_length = shipped
    code = SEGMENTS.index("turn_left_sharp")
    length = library.length[0, code]
    path, _ = _play(library, code, length - 6, 30, code)
    assert _changes(path).max() <= max(LIMIT * usual[code], MOST_JERK_BL * body_length)
