"""Pause, single ticks, rates and rewind to the same worlds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior.teleop import TeleopCommand
from subsea.dive import timeline as module
from subsea.dive.pilot import Pilot
from subsea.dive.tick_source import LocalTicks
from subsea.dive.timeline import RATES, Timeline
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import Helm, Rail
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.to_scenario import equal_tunables, get_tunables, set_tunables
from subsea.world.world import TICK_S

REACH, KEPT = 50, 7  # ticks; shorter than in a dive


@pytest.fixture(scope="module")
def begun():
    """A world with a simulated fish, its initial state, and a short timeline."""
    world = create_world(load_scenario("peaceful")[0], fish=9, live=1, live_reach_cm=np.inf)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "REACH_TICKS", REACH)
        patch.setattr(module, "KEPT_TICKS", KEPT)
        yield world, snapshot.take(world), get_tunables(world)


@pytest.fixture
def world(begun):
    return afresh(begun)


class Log:
    """The state of a world at each tick of its timeline."""

    def __init__(self, world, time):
        self.world, self.time, self.was = world, time, {}
        self.note()

    def note(self):
        for tick in [tick for tick in self.was if tick > self.time.tick]:
            del self.was[tick]
        self.was[self.time.tick] = snapshot.checksum(self.world), get_tunables(self.world)

    def assert_restored(self):
        checksum, constants = self.was[self.time.tick]
        assert snapshot.checksum(self.world) == checksum
        assert equal_tunables(get_tunables(self.world), constants)


def afresh(begun):
    world, whole, constants = begun
    set_tunables(world, constants)
    snapshot.restore(world, whole)
    return world


share = st.floats(-1.0, 1.0, width=16)
orders = st.one_of(
    st.builds(Helm, share, share, share, share, st.booleans()),
    st.builds(TeleopCommand, st.integers(0, 8), share, share, share),
    st.builds(
        lambda x, pan: Rail(np.array([x, 0.0, -200.0]), np.array([30.0, 0.0, 0.0]), (pan, 0.1)),
        st.floats(-100.0, 100.0), share,
    ),
)  # fmt: skip
deeds = st.one_of(
    st.tuples(st.just("play"), st.lists(orders, min_size=1, max_size=4), st.integers(1, 12)),
    st.tuples(st.just("go"), st.integers(-20, 70)),
    st.tuples(st.just("single"), orders),
    st.tuples(st.just("rewind"), st.integers(1, 3)),
    st.tuples(st.just("nature"), st.floats(0.05, 0.9)),
    st.tuples(st.just("physics"), st.floats(0.5, 2.0)),
    st.tuples(st.just("hunger"), st.integers(0, 8)),
    st.tuples(st.just("light"), st.floats(0.0, 1.0)),
)


@given(st.lists(deeds, min_size=2, max_size=12), st.randoms(use_true_random=False))
def test_restored_ticks_equal_the_original_ones(begun, what, chance):
    world = afresh(begun)
    time = Timeline(world)
    log = Log(world, time)

    def made(order):
        time.make(order)
        log.note()

    for name, *given_ in what:
        if name == "play":
            steered, ticks = given_
            for k in range(ticks):
                made(steered[k % len(steered)])
        elif name == "go":
            time.go(given_[0])
        elif name == "single":
            before, latest, time.paused = time.tick, time.latest, True
            time.single()
            new = time.due(0.1)
            assert new == (before == latest)
            if new:
                made(given_[0])
            assert time.tick == before + 1
        elif name == "rewind":
            for _ in range(given_[0]):
                time.rewind(10 * TICK_S)
            back, time.paused = max(time.tick - 10 * given_[0], time.earliest), True
            time.due(0.0)
            assert time.tick == back
        else:
            if name == "nature":
                world.nature = world.nature._replace(keen=given_[0])
            elif name == "physics":
                world.physics = world.physics._replace(water_viscosity=given_[0])
            elif name == "hunger":
                world.state.minds.eaten[given_[0]] = 0.0
            else:
                world.seen_light[3] = given_[0]
            time.touch()
            log.note()
        log.assert_restored()
        assert time.earliest <= max(time.latest - REACH, 0)
        assert time.latest - time.earliest < REACH + KEPT
        assert time.latest == max(log.was)
    there = range(time.earliest, time.latest + 1)
    for tick in chance.sample(there, min(5, len(there))):
        time.go(tick)
        assert time.tick == tick
        log.assert_restored()


def test_the_same_orders_repeat_the_same_ticks(world):
    time = Timeline(world)
    orders = [Helm(surge=0.5, yaw=0.1 * (k % 5 - 2)) for k in range(20)]
    orders += [TeleopCommand(4, 0.5, 0.2, 0.8)] * 20
    first = []
    for order in orders:
        time.make(order)
        first.append(snapshot.checksum(world))
    time.go(5)
    again = []
    for order in orders[5:]:
        time.make(order)
        again.append(snapshot.checksum(world))
    assert again == first[5:]
    time.go(5)
    time.make(Helm(surge=-1.0))
    assert time.latest == 6  # later ticks are dropped
    assert snapshot.checksum(world) != first[5]


@pytest.mark.nightly
def test_little_memory_shortens_the_range_of_rewinding(world):
    time = Timeline(world)
    one = time.bytes
    for k in range(3 * REACH):
        time.make(Helm())
        if k > REACH and k % 3 == 0:
            time.touch()  # as a dragged slider does
    assert time.bytes > 10 * one
    short = Timeline(world, most_bytes=4 * one)
    for _ in range(3 * REACH):
        short.make(Helm())
        assert short.bytes <= 4 * one
    assert 2 * KEPT <= short.latest - short.earliest <= 4 * KEPT
    last = snapshot.checksum(world)
    short.go(0)
    assert short.tick == short.earliest > 0
    short.go(10**6)
    assert snapshot.checksum(world) == last


@pytest.mark.nightly
def test_dragging_a_slider_hardly_shortens_the_range_of_rewinding(world):
    time = Timeline(world)
    one = time.bytes
    time = Timeline(world, most_bytes=(4 + 3 * REACH // KEPT) * one)
    log = Log(world, time)
    for k in range(2 * REACH):
        time.make(Helm(surge=0.5))
        world.nature = world.nature._replace(keen=0.1 + 0.8 * (k % 9) / 9)
        world.state.minds.eaten[k % 9] = 0.0
        time.touch()
        log.note()
    assert time.bytes <= (4 + 3 * REACH // KEPT) * one
    assert time.latest - time.earliest >= REACH - KEPT

    for asked in [*range(time.latest, time.earliest, -3), *range(time.earliest, time.latest)]:
        before = time.tick
        time.go(asked)
        assert abs(time.tick - asked) < KEPT
        assert (time.tick - asked) * (asked - before) >= 0  # never stuck on the way
        log.assert_restored()
    time.go(time.earliest)
    time.paused = True
    seen = [time.tick]
    while time.tick < time.latest:  # single ticks reach the end
        time.single()
        assert time.due(0.1) == 0
        log.assert_restored()
        seen.append(time.tick)
    assert max(np.diff(seen)) <= KEPT and min(np.diff(seen)) >= 1
    time.go(time.latest - KEPT)  # all ticks made from there on can be restored
    begin = time.tick
    for _ in range(KEPT):
        time.make(Helm(surge=-0.5))
        log.note()
    for tick in range(begin, time.latest + 1):
        time.go(tick)
        assert time.tick == tick
        log.assert_restored()


class CountingPilot(Pilot):
    """A pilot that counts its calls."""

    asked = 0

    def helm(self, dt):
        self.asked += 1
        return Helm(surge=0.02 * self.asked)


def test_pause_single_ticks_and_rates(world):
    ticks = LocalTicks(world, pilot := CountingPilot())
    time = ticks.timeline
    for _ in range(10):
        ticks.advance(TICK_S)
    at = time.tick
    assert at == pilot.asked == pytest.approx(10, abs=1)
    time.pause()
    assert ticks.advance(5.0) == 1.0
    assert (time.tick, time.text) == (at, "paused")
    time.single()
    ticks.advance(5.0)
    ticks.advance(5.0)
    assert time.tick == at + 1
    time.pause()
    assert ticks.advance(0.25 * TICK_S) == pytest.approx(0.25)  # it continues from the shown point
    assert time.tick == at + 2
    assert time.text == ""
    for call, expected in ((time.slower, RATES[1::-1]), (time.faster, RATES[1:])):
        for rate in (*expected, expected[-1]):
            call()
            assert time.rate == rate
            assert time.text == ("" if rate == 1.0 else f"time ×{rate:g}")
            before = time.tick
            for _ in range(16):
                ticks.advance(TICK_S)
            assert time.tick - before == pytest.approx(16 * rate, abs=1)


def test_rewinding_asks_neither_pilot_nor_tour(world):
    pilot, legs = Pilot(), []

    def tour(there):
        legs.append(there.state.tick)
        return Helm(yaw=0.5)

    pilot.helm = lambda dt: Helm()
    ticks = LocalTicks(world, pilot, tour)
    time = ticks.timeline
    was = []
    for _ in range(45):
        ticks.advance(TICK_S)
        was.append(snapshot.checksum(world))
    asked = len(legs)
    time.pause()
    for seconds in (1.0, 0.1):
        time.rewind(seconds)
    ticks.advance(0.0)
    back = round(1.0 / TICK_S) + round(0.1 / TICK_S)
    assert snapshot.checksum(world) == was[-1 - back]
    assert time.text == f"paused, {back * TICK_S:.1f} s back"
    time.single()
    ticks.advance(0.0)
    assert snapshot.checksum(world) == was[-back]
    assert len(legs) == asked
    time.pause()
    ticks.advance(0.0)  # the tour's tick that was already shown
    assert len(legs) == asked + 1
    assert time.latest == time.tick
