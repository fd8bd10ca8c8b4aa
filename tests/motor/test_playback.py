"""Playback against recorded motion."""

from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from subsea.biomechanics.body import body_frame
from subsea.geometry.rotation import about, from_matrix, matrix, multiply
from subsea.motor.playback import advance, play
from subsea.motor.pose import nodes_world
from subsea.repertoire.schema import BASIC_SEGMENTS, SEGMENTS
from subsea.state import Fishes, empty
from tests.support.scenes import everyone

TICK = 0.033
STILL = np.zeros(3)


def _put(fishes, nodes, turn=None, shift=0.0):
    """Place fish 0 at the body frame of world `nodes`, turned and shifted."""
    origin, R = body_frame(nodes)
    turn = np.eye(3) if turn is None else turn
    fishes.position[0] = turn @ origin + shift
    fishes.orientation[0] = from_matrix(turn @ R)


def _advance(fishes, library, i=0):
    """One tick of recorded motion alone: no steering, balance or current."""
    o, q = advance(fishes, library, i)
    fishes.position[i], fishes.orientation[i] = o, q / np.linalg.norm(q)


def _path(fishes, library, ticks):
    path = []
    for _ in range(ticks):
        _advance(fishes, library)
        path.append(nodes_world(fishes, library, 0))
    return np.array(path)


def test_ten_cycles_stay_on_the_recorded_motion(library, make_fishes, known_motion):
    fishes = make_fishes(1, "swim_fast")
    _put(fishes, known_motion(0.0, 0.10, 12, 20 * TICK, 0.0))
    path = _path(fishes, library, 120)
    expected = np.array([known_motion(t, 0.10, 12, 20 * TICK, 0.0) for t in range(1, 121)])
    assert np.abs(path - expected).max() < 2e-3 * 20  # float32 over 120 increments


def test_a_turning_cycle_bends_the_path_as_recorded(library, make_fishes, known_motion):
    fishes = make_fishes(1, "turn_left_gradual")
    turn = np.radians(1.5)
    _put(fishes, known_motion(0.0, 0.06, 12, 10 * TICK, turn))
    path = _path(fishes, library, 60)
    expected = np.array([known_motion(t, 0.06, 12, 10 * TICK, turn) for t in range(1, 61)])
    assert np.abs(path - expected).max() < 4e-3 * 20


@given(turn=st.tuples(*[st.floats(-1, 1)] * 4), scale=st.floats(0.4, 2.5))
def test_playback_is_equivariant(library, turn, scale):
    """The same segment at another place, attitude and size gives the same motion."""
    assume(np.linalg.norm(turn) > 0.1)
    fishes = empty(Fishes, n=2)
    for array, value in (
        (fishes.segment, SEGMENTS.index("swim_fast")),
        (fishes.wanted_segment, SEGMENTS.index("swim_fast")),
        (fishes.row_a, library.first[0, 2] + 11),
        (fishes.row_b, library.first[0, 2]),
        (fishes.length, 20.0),
    ):
        array[:] = value
    upright = about(1.0, 0.0, 0.0, np.pi / 2)
    turned = multiply(tuple(np.array(turn) / np.linalg.norm(turn)), upright)
    fishes.orientation[0], fishes.orientation[1] = upright, turned
    fishes.position[1] = 10.0, -20.0, -30.0
    fishes.scale[1] = scale
    fishes.rate[:] = 1.0
    for _ in range(36):
        _advance(fishes, library, 0)
        _advance(fishes, library, 1)
    to_other = matrix(turned) @ matrix(upright).T
    there = to_other @ fishes.position[0] * scale + [10.0, -20.0, -30.0]
    np.testing.assert_allclose(fishes.position[1], there, atol=0.02 * scale)
    R0, R1 = (matrix(fishes.orientation[k].astype(float)) for k in (0, 1))
    np.testing.assert_allclose(R1, to_other @ R0, atol=2e-3)


@pytest.mark.parametrize("rate", [0.37, 0.8, 1.0, 1.7])
def test_any_rate_traces_the_same_path(library, make_fishes, known_motion, rate):
    fishes = make_fishes(1, "turn_left_gradual")
    turn = np.radians(1.5)
    _put(fishes, known_motion(0.0, 0.06, 12, 10 * TICK, turn))
    fishes.rate[:] = rate
    ticks = 40
    path = _path(fishes, library, ticks)
    origin, _ = body_frame(known_motion(rate * ticks, 0.06, 12, 10 * TICK, turn))
    place, _ = body_frame(path[-1])
    assert np.abs(place - origin).max() < 0.15  # between rows the body is a chord of the path


def test_a_larger_fish_covers_more_ground_a_beat(library, make_fishes):
    fishes = make_fishes(2, "swim_fast")
    fishes.scale[1] = 2.0
    for _ in range(24):
        play(everyone(fishes), fishes, library, TICK)
    moved = np.linalg.norm(fishes.position, axis=1)
    np.testing.assert_allclose(moved[1] / moved[0], 2.0, rtol=1e-4)


def test_the_current_carries_fishes(library, make_fishes):
    fishes = make_fishes(2, "swim_slow")
    drifting = make_fishes(2, "swim_slow")
    drifting.drift[:] = 5.0, -2.0, 1.0
    for _ in range(30):
        play(everyone(fishes), fishes, library, TICK)
        play(everyone(drifting), drifting, library, TICK)
    gone = drifting.position - fishes.position
    np.testing.assert_allclose(gone, 30 * TICK * np.array([[5.0, -2.0, 1.0]] * 2), atol=1e-3)


def _largest_step(library, make_fishes, name):
    """Largest displacement of any node per tick inside a segment."""
    fishes = make_fishes(1, name)
    path = _path(fishes, library, 11)
    return np.linalg.norm(np.diff(path, axis=0), axis=2).max()


def test_glides_keep_the_way_and_make_no_leap(library, make_fishes):
    """Between any two segments the fish never nearly stops, and no node leaps."""
    usual = {name: _largest_step(library, make_fishes, name) for name in BASIC_SEGMENTS}
    for before, after in product(BASIC_SEGMENTS, repeat=2):
        fishes = make_fishes(1, before)
        fishes.orientation[0] = about(1.0, 0.0, 0.0, np.pi / 2)
        # An acyclic segment is played to its end first.
        for _ in range(5):
            play(everyone(fishes), fishes, library, TICK)
        fishes.wanted_segment[:] = SEGMENTS.index(after)
        nodes, speeds = [nodes_world(fishes, library, 0)], []
        for _ in range(40):
            play(everyone(fishes), fishes, library, TICK)
            nodes.append(nodes_world(fishes, library, 0))
            speeds.append(np.linalg.norm(fishes.velocity[0]))
        where = f"{before} to {after}"
        assert fishes.segment[0] == SEGMENTS.index(after), where
        step = np.linalg.norm(np.diff(nodes, axis=0), axis=2).max()
        tempo = max(float(fishes.tempo[0]), 1.0)  # it takes up the speed that a turn has not
        assert step < 1.4 * tempo * max(usual[before], usual[after]), where
        codes = [SEGMENTS.index(before), SEGMENTS.index(after)]
        assert min(speeds) > 0.6 * library.speed[0, codes].min(), where


def test_a_turn_waits_for_the_beat_but_not_for_long(library, make_fishes):
    """The turn begins within a beat from any phase of a swim."""
    for after, phase in product(BASIC_SEGMENTS[3:], range(12)):
        fishes = make_fishes(1, "swim_medium")
        for _ in range(phase):
            play(everyone(fishes), fishes, library, TICK)
        fishes.wanted_segment[:] = SEGMENTS.index(after)
        waited = 0
        while fishes.segment[0] != SEGMENTS.index(after):
            play(everyone(fishes), fishes, library, TICK)
            waited += 1
        assert waited <= 12, f"{after}, phase {phase}"


def test_a_sharp_turn_is_played_to_its_end(library, make_fishes):
    fishes = make_fishes(1, "turn_left_sharp")
    fishes.wanted_segment[:] = SEGMENTS.index("swim_slow")
    for _ in range(11):
        play(everyone(fishes), fishes, library, TICK)
        assert fishes.segment[0] == SEGMENTS.index("turn_left_sharp")
    for _ in range(3):
        play(everyone(fishes), fishes, library, TICK)
    assert fishes.segment[0] == SEGMENTS.index("swim_slow")
