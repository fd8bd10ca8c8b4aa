"""Escapes, rowing and coasting, of a repertoire in closed form that has them."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.fish.skinning import couple
from subsea.geometry.rotation import about, matrix
from subsea.motor.controller import command
from subsea.motor.playback import play
from subsea.repertoire import SEGMENTS
from subsea.repertoire.library import pack
from subsea.state import Clock
from tests.conftest import TICK_S, segment
from tests.support.scenes import everyone

CSTART, STOP, ROW = (
    SEGMENTS.index(name) for name in ("cstart_left_moderate", "swim_stop", "row_forward")
)
FAST = 20.0 * TICK_S  # cm per tick


@pytest.fixture(scope="module")
def rich(known_repertoire):
    """The library of the known repertoire and a set of further segments."""

    def make(*names):
        forms = {
            "cstart_left_moderate": ("left", "moderate", 0.08, 0.5 * FAST, np.radians(6.0)),
            "swim_stop": ("forward", "stop", 0.0, 0.05 * FAST, 0.0),
            "row_forward": ("forward", "forward", 0.0, 0.25 * FAST, 0.0),
        }
        more = {n: replace(segment(*forms[n]), cyclic=n == "row_forward") for n in names}
        one = replace(known_repertoire, segments={**known_repertoire.segments, **more})
        return pack([one], [couple("sections", one.rest_nodes, np.zeros((426, 3)))])

    return make


@pytest.fixture
def fish(make_fishes):
    fishes = make_fishes(1, "swim_medium")
    fishes.orientation[:] = about(1.0, 0.0, 0.0, np.pi / 2)
    fishes.burst[:] = 3.0
    return fishes


def _run(fishes, library, speed, ticks, begin=0):
    """Advance toward +x; returns speeds (T,) over the fast swim's."""
    speeds = []
    for tick in range(begin, begin + ticks):
        fishes.goal_speed[:] = speed
        command(everyone(fishes), fishes, library, Clock(1, tick, TICK_S))
        play(everyone(fishes), fishes, library, TICK_S)
        speeds.append(float(fishes.velocity[0, :2] @ matrix(fishes.orientation[0])[:2, 0]))
    return np.array(speeds) * TICK_S / FAST


def test_an_escape_begins_at_once_and_is_played_to_its_end(rich, fish):
    library = rich("cstart_left_moderate")
    for phase in range(12):
        _run(fish, library, 0.5, phase + 40)
        fish.startle[:] = np.radians(72.0)
        waited = 0
        while fish.segment[0] != CSTART and waited < 9:
            _run(fish, library, 2.0, 1)
            waited += 1
        assert waited <= 2, phase
        assert fish.startle[0] == 0.0
        played = 0
        while fish.segment[0] == CSTART and played < 99:
            _run(fish, library, 2.0, 1)
            played += 1
        assert 3 <= played <= 9, phase  # 12 rows and the glide, at a tempo of 3


def test_a_rower_keeps_its_body_rigid_and_its_speed(rich, fish):
    library = rich("row_forward")
    for speed in (0.25, 0.12, 0.0, -0.06):
        _run(fish, library, speed, 120)
        speeds = _run(fish, library, speed, 60)
        assert fish.segment[0] == ROW
        assert speeds.mean() == pytest.approx(speed, abs=0.01)
    _run(fish, library, 0.9, 60)
    assert fish.segment[0] != ROW


def test_a_fish_that_stops_does_not_beat(rich, fish):
    library = rich("swim_stop")
    _run(fish, library, 0.6, 60)
    _run(fish, library, 0.0, 90)
    rows = []
    for _ in range(60):
        speeds = _run(fish, library, 0.0, 1)
        rows.append(int(fish.row_a[0]))
    assert set(rows) == {int(library.first[0, STOP]) + 11}
    assert abs(speeds[-1]) < 0.01


def test_below_the_slowest_beat_the_share_of_beats_sets_the_speed(rich, fish):
    library = rich("swim_stop")
    least = 0.4 * 0.3
    for share in (0.5, 0.8):
        speeds = _run(fish, library, share * least, 1820)
        assert speeds.mean() == pytest.approx(share * least, rel=0.35)
