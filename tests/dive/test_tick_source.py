"""Sources of the ticks of a dive on one computer."""

from types import SimpleNamespace

import numpy as np
import pytest

from subsea.dive.pilot import Pilot
from subsea.dive.tick_source import LocalTicks
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.ui import dive
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S


@pytest.fixture(scope="module")
def world():
    made = create_world(load_scenario("schooling")[0], fish=3)
    step(made, NEUTRAL)
    return made


def pressed(action):
    pilot = Pilot()
    pilot.hold(action, "W")
    return pilot


def test_local_ticks_follow_the_clock_and_the_pilot(world):
    ticks, tick = LocalTicks(world, pressed("ahead")), world.state.tick
    assert ticks.advance(2.5 * TICK_S) == pytest.approx(0.5)
    assert world.state.tick == tick + 2
    assert ticks.advance(0.25 * TICK_S) == pytest.approx(0.75)
    assert world.state.tick == tick + 2
    ticks.swap(None)
    ticks.advance(4 * TICK_S)
    assert np.linalg.norm(world.state.submarine.velocity) > 1.0
    assert (ticks.has_pilot, ticks.shared, ticks.waiting, ticks.idle_s) == (True, False, "", 0.0)
    assert ticks.close() == []


def test_a_tour_starts_in_the_resumed_dive(world, monkeypatch):
    """After the resumed state, which has another place of the submarine, and before any picture."""
    done = []
    ticks = SimpleNamespace(
        resume=lambda check: done.append("resumed"),
        set_tour=lambda tour: done.append(tour),
        eye=lambda: None,
        offer=lambda source: None,
    )
    running = SimpleNamespace(
        parts=[],
        _make_ticks=lambda world, pilot: done.append("listens") or ticks,
        _close_ticks=None,
        pilot=None,
        timeline=None,
        source=None,
        _set_overlays=lambda: None,
        picture=SimpleNamespace(open_world=lambda *given: done.append("scene"), close_world=None),
        inspector=SimpleNamespace(reset=lambda: None),
        card=SimpleNamespace(clear=lambda: None),
        sound=SimpleNamespace(fish=None, attend=lambda world: done.append("heard")),
    )
    monkeypatch.setattr(dive, "endless_tour", lambda world, tour: done.append("boarded") or tour)
    dive.Dive._show_world(running, world, tour="reef")
    assert done == ["scene", "listens", "resumed", "boarded", "reef", "heard"]
