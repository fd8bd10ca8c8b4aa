"""Every transition of every shipped species is smooth for all nodes."""

from itertools import product

import numpy as np
import pytest

from subsea.biomechanics.manoeuvres import MOST_JERK_BL
from subsea.fish.species import species_names
from subsea.geometry.rotation import matrix
from subsea.motor.playback import advance
from subsea.repertoire import SEGMENTS
from subsea.state import Fishes, empty
from tests.support.daily import only

LIMIT = 2.0  # times the largest change of velocity inside the two segments, or ...
SMOOTH_BL = 0.05  # ... body lengths per tick² between swims and gradual turns, and ...
# ... what the recorder allows inside a manoeuvre, from or to one.
AFTER = 16  # ticks after the change


@pytest.fixture(scope="module", params=only(("fusilier", "ribbon_eel"), species_names()))
def shipped(request, shipped_library):
    """The library of one species, the largest change inside each segment, and the length in cm."""
    repertoire, _, library = shipped_library(request.param)
    usual = []
    for code in range(len(SEGMENTS)):
        length = library.length[0, code]
        path, _ = _play(library, code, [1], 2 * length if library.cyclic[0, code] else length - 2)
        usual.append(_changes(path).max())
    return library, np.array(usual), repertoire.body_length_cm


def _play(library, code, phases, ticks, wanted=None):
    """Nodes (T, n, 23, 3), cm, world, segments (T, n) of fishes from rows `phases` of a segment.

    Fishes with a `wanted` segment each are followed until all have had it for `AFTER` ticks.
    """
    fishes = empty(Fishes, n=len(phases))
    first, length = library.first[0, code], library.length[0, code]
    fishes.segment[:] = code
    fishes.wanted_segment[:] = code if wanted is None else wanted
    fishes.length[:] = library.recorded_length[0]
    fishes.row_a[:] = first + (np.asarray(phases) - 1) % length
    fishes.row_b[:] = first + np.asarray(phases)
    path, segments, since = [_nodes(fishes, library)], [fishes.segment.copy()], 0
    while len(path) <= ticks and since < AFTER:
        for i in range(len(phases)):
            o, q = advance(fishes, library, i)
            fishes.position[i], fishes.orientation[i] = o, q / np.linalg.norm(q)
        path.append(_nodes(fishes, library))
        segments.append(fishes.segment.copy())
        since += wanted is not None and bool((fishes.segment == wanted).all())
    return np.array(path), np.array(segments)


def _nodes(fishes, library):
    """The nodes (n, 23, 3) of all fishes, as `nodes_world` gives those of one."""
    w = fishes.weight[:, None, None]
    body = (1.0 - w) * library.nodes[fishes.row_a] + w * library.nodes[fishes.row_b]
    turned = (fishes.scale[:, None, None] * body) @ matrix(fishes.orientation).swapaxes(1, 2)
    return fishes.position[:, None] + turned


def _changes(path):
    """The largest change of any node's velocity (T - 2, n) at each frame, cm per tick²."""
    return np.linalg.norm(np.diff(path, 2, axis=0), axis=3).max(axis=2)


def test_no_node_is_jerked(shipped):
    library, usual, body_length = shipped
    segments = np.flatnonzero(library.has[0])
    for before in segments:
        length = library.length[0, before]
        phases = range(0, length, 2) if library.cyclic[0, before] else [length - 6]
        cases = [case for case in product(segments, phases) if case[0] != before]
        wanted, starts = np.array(cases).T
        path, codes = _play(library, before, starts, 2 * length + 90, wanted)
        changes, switched = _changes(path), codes == wanted
        assert switched[-1].all()
        for i, (after, phase) in enumerate(cases):
            at = int(np.argmax(switched[:, i]))
            swims = library.cyclic[0, before] and library.cyclic[0, after]
            least = (SMOOTH_BL if swims else MOST_JERK_BL) * body_length
            limit = max(LIMIT * usual[before], LIMIT * usual[after], least)
            where = f"{SEGMENTS[before]} to {SEGMENTS[after]}, phase {phase}"
            assert changes[max(at - 3, 0) : at + 14, i].max() <= limit, where


def test_a_turn_of_more_than_its_angle_is_two_turns(shipped):
    """A sharp turn that is still wanted at its end continues without a jerk."""
    library, usual, body_length = shipped
    code = SEGMENTS.index("turn_left_sharp")
    path, _ = _play(library, code, [library.length[0, code] - 6], 30)
    assert _changes(path).max() <= max(LIMIT * usual[code], MOST_JERK_BL * body_length)
