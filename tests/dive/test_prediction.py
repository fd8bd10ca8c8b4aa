"""The submarine is drawn without delay or jerks; input shows in the next picture."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.dive.pilot import CATCH_UP_S, Pilot, Prediction
from subsea.dive.tick_source import LocalTicks
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import AHEAD_CM_S, HEAVE_CM_S, NEUTRAL, YAW_RAD_S, Helm, Rail
from subsea.view.display_rigs import cockpit
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import steer, step
from subsea.world.world import TICK_S

FASTEST_CM_S = math.hypot(AHEAD_CM_S, HEAVE_CM_S) + 20.0 * YAW_RAD_S  # of an eye before the hull
SHARES = st.floats(-1.0, 1.0)
HELMS = st.builds(Helm, SHARES, SHARES, SHARES, SHARES, st.booleans())


@pytest.fixture(scope="module")
def world():
    made = create_world(load_scenario("schooling")[0], fish=3)
    step(made, NEUTRAL)
    return made


@pytest.fixture(scope="module")
def begin(world):
    return snapshot.take(world)


def pictures(ticks, rate, seconds):
    """The eye's pose in each picture of a display with `rate` pictures a second."""
    for _ in range(round(rate * seconds)):
        ticks.advance(1.0 / rate)
        yield ticks.eye()


def apart(one, other):
    """The distance between two poses: cm and rad."""
    turn = np.linalg.norm(np.cross(one.forward, other.forward))
    return float(np.linalg.norm(one.eye - other.eye)), float(np.arcsin(min(turn, 1.0)))


@given(helm=HELMS, late=st.floats(0.0, 1.0), ticks=st.integers(1, 40))
def test_the_prediction_meets_the_next_tick(world, begin, helm, late, ticks):
    snapshot.restore(world, begin)
    present, submarine = Prediction(), world.state.submarine
    present.update(0.0, known=False)
    present.update(CATCH_UP_S * (1.0 - late), known=True)
    for _ in range(ticks):
        steer(world, submarine, helm)
    before = snapshot.checksum(world)
    last = present.eye(world, 1.0, helm)
    assert snapshot.checksum(world) == before  # prediction changes nothing
    steer(world, submarine, helm)
    first = present.eye(world, 0.0, helm)
    assert apart(first, last) == pytest.approx((0.0, 0.0), abs=1e-7)
    if late == 0.0:
        assert apart(first, cockpit(submarine, 1.0)) == pytest.approx((0.0, 0.0), abs=1e-7)


@pytest.mark.parametrize("rate", [24.0, 60.0, 144.0])
@pytest.mark.parametrize("held", ["ahead", "left", "up", "dive"])
def test_the_eye_moves_smoothly_under_constant_input(world, begin, rate, held):
    snapshot.restore(world, begin)
    pilot = Pilot()
    pilot.hold(held, "W")
    seen = list(pictures(LocalTicks(world, pilot), rate, 2.0))
    moves = np.array([apart(*pair) for pair in pairwise(seen)])
    assert (moves[:, 0] < FASTEST_CM_S / rate).all()
    assert (moves[:, 1] < 1.05 * YAW_RAD_S / rate).all()
    assert max(moves[-1, 0] * rate / 20.0, moves[-1, 1] * rate / 0.1) > 1.0  # it does move
    # Each picture moves like the one before, plus the effect of the helm in a tick.
    eye = np.diff([one.eye for one in seen], n=2, axis=0)
    assert np.linalg.norm(eye, axis=1).max() * rate < 0.1 * FASTEST_CM_S


def changed(world, begin, held, phase, rate):
    """True if a key that is pressed at a phase of a tick shows in the first and second picture."""
    seen = []
    for pressed in (False, True):
        snapshot.restore(world, begin)
        pilot = Pilot()
        ticks = LocalTicks(world, pilot)
        ticks.advance((1.0 + phase) * TICK_S)
        if pressed:
            pilot.hold(held, "W")
        seen.append(list(pictures(ticks, rate, 2.0 / rate)))
    return [max(apart(*pair)) > 1e-5 for pair in zip(*seen, strict=True)]


@pytest.mark.parametrize("rate", [60.0, 144.0])
@pytest.mark.parametrize("held", ["ahead", "left", "up", "dive"])
def test_a_key_shows_within_two_pictures(world, begin, rate, held):
    for phase in (0.0, 0.3, 0.5, 0.999):
        assert changed(world, begin, held, phase, rate)[1]


def test_most_keys_show_in_the_first_picture(world, begin):
    assert sum(changed(world, begin, "left", k / 20.0, 60.0)[0] for k in range(20)) >= 19


def test_the_prediction_starts_gently_after_a_tour(world, begin):
    snapshot.restore(world, begin)
    start, way = world.state.submarine.position.copy(), np.array([60.0, 0.0, 0.0])

    def tour(world):
        return Rail(start + (world.state.tick + 1) * TICK_S * way, way, (0.0, 0.0))

    pilot, rate = Pilot(), 60.0
    ticks = LocalTicks(world, pilot, tour)
    for eye in pictures(ticks, rate, 1.0):
        late = cockpit(world.state.submarine, ticks.timeline.alpha)
        assert apart(eye, late) == pytest.approx((0.0, 0.0), abs=1e-7)
    pilot.hold("ahead", "W")
    seen = [eye.eye[0] for eye in pictures(ticks, rate, 1.0)]
    moves = np.diff(seen) * rate
    assert (moves > 0.0).all() and moves.max() < 1.2 * AHEAD_CM_S
    assert apart(ticks.eye(), cockpit(world.state.submarine, 0.0))[0] > 0.0
    ahead = ticks.eye().eye[0] - cockpit(world.state.submarine, 1.0).eye[0]
    assert ahead == pytest.approx(moves[-1] * ticks.timeline.alpha * TICK_S, rel=0.05, abs=1e-3)


def test_the_eye_stands_still_while_time_is_paused(world, begin):
    snapshot.restore(world, begin)
    pilot = Pilot()
    ticks = LocalTicks(world, pilot)
    pilot.hold("ahead", "W")
    list(pictures(ticks, 60.0, 1.0))
    ticks.timeline.pause()
    seen = list(pictures(ticks, 60.0, 0.5))
    assert all(apart(one, seen[0])[0] == 0.0 for one in seen)
    assert apart(seen[0], cockpit(world.state.submarine, 1.0)) == pytest.approx((0.0, 0.0))
    ticks.timeline.pause()
    again = [*seen[-1:], *pictures(ticks, 60.0, 0.5)]
    moves = [apart(*pair)[0] for pair in pairwise(again)]
    assert max(moves) < FASTEST_CM_S / 60.0
