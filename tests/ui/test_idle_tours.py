"""Idle tours and a kiosk in a real window, by real input."""

from contextlib import closing

import numpy as np
import pytest

from subsea.dive.idle_timer import DIP_S
from subsea.dive.settings import AttractSettings, Settings
from subsea.submarine.vessel import ACCELERATION_CM_S2
from subsea.ui.dive import Dive
from subsea.world.world import TICK_S
from tests.support.daily import only
from tests.support.windows import dive_options

SIZE = (320, 240)
AFTER_S = 2.0
PATIENT = Settings(attract=AttractSettings(after_min=AFTER_S / 60.0))


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    with closing(Dive(dive_options(quiet, SIZE, coarse, settings=PATIENT))) as running:
        user.glide(running, 0.2)
        yield running


def taken(running):
    """True if a tour steers the submarine."""
    return running.tours.timer.touring and running.tick_source.steering.tour is not None


def awaited(running, user, seconds=AFTER_S):
    """Let this time pass without input."""
    user.glide(running, seconds + 0.5)


def frame(running):
    """Run one frame; return the hull's distance and change of velocity in it."""
    submarine = running.world.state.submarine
    place, velocity = submarine.position.copy(), submarine.velocity.copy()
    running.frame(TICK_S)
    return (
        np.linalg.norm(submarine.position - place),
        np.linalg.norm(submarine.velocity - velocity),
    )


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("tour", "words"),
    only(
        [("auto", ("mousemove_relative", 30, 5))],
        [("auto", ("mousemove_relative", 30, 5)), ("reef", ("key", "h"))],
    ),
)
def test_a_tour_begins_without_input_and_ends_at_input(boat, user, tour, words):
    boat.tours.name, boat.tours.timer.leaps = tour, tour != "auto"
    user.point(boat, 0.0, 0.0)
    user.until(boat, lambda: not boat.tours.timer.touring)
    user.glide(boat, AFTER_S - 0.5)
    assert not taken(boat)
    boat.overlay.show_help()  # a visitor opened it: it must not cover the tour
    awaited(boat, user, AFTER_S + 2.0 * DIP_S)
    assert taken(boat)
    user.glide(boat, 5.0)
    assert boat.overlay.help_opacity == 0.0
    assert np.linalg.norm(boat.world.state.submarine.velocity) > 5.0
    assert boat.overlay.hud.opacity == 0.0
    user.do(*words)
    for _ in range(200):
        touring = boat.tours.timer.touring
        gone, faster = frame(boat)
        assert gone < 5.0
        if touring != boat.tours.timer.touring:
            assert boat.tick_source.steering.tour is None  # in the same picture
            assert faster < 1.5 * ACCELERATION_CM_S2 * TICK_S
            break
    assert not boat.tours.timer.touring
    for _ in range(60):
        gone, faster = frame(boat)
        assert gone < 5.0 and faster < 1.5 * ACCELERATION_CM_S2 * TICK_S
    assert boat.overlay.help_opacity > 0.9  # for a new visitor


def test_a_tour_begins_although_a_fish_is_ridden(boat, user):
    user.do("key", "r")
    user.until(boat, lambda: boat.pilot.riding)
    awaited(boat, user, AFTER_S + 2.0 * DIP_S)
    assert taken(boat) and not boat.pilot.riding
    user.do("key", "w")
    user.until(boat, lambda: not boat.tours.timer.touring)


@pytest.mark.nightly
def test_no_tour_begins_while_the_inspector_is_open_or_time_paused(boat, user):
    for key in ("Tab", "k"):
        user.do("key", key)
        user.until(boat, lambda: boat.inspector.open or boat.timeline.paused)
        awaited(boat, user, AFTER_S + 2.0 * DIP_S)
        assert not boat.tours.timer.touring
        user.do("key", key)
        user.until(boat, lambda: not (boat.inspector.open or boat.timeline.paused))
