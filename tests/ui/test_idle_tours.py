"""Idle tours and a kiosk in a real window, by real input."""

import re
from contextlib import closing

import numpy as np
import pytest

from subsea.core.resources import resource_path
from subsea.dive.idle_timer import DIP_S
from subsea.dive.settings import AttractSettings, Settings
from subsea.submarine.hull import ACCELERATION_CM_S2
from subsea.ui.dive import Dive
from subsea.world.world import TICK_S
from tests.support.windows import dive_options

SIZE = (320, 240)
AFTER_S = 2.0
PATIENT = Settings(attract=AttractSettings(after_min=AFTER_S / 60.0))


def sea(folder):
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    quiet = folder / "quiet.toml"
    quiet.write_text(re.sub(r"^number = \d+", "number = 2", text, flags=re.MULTILINE))
    return str(quiet)


@pytest.fixture(scope="module")
def boat(display, hands, coarse, tmp_path_factory):
    sea_file = sea(tmp_path_factory.mktemp("sea"))
    with closing(Dive(dive_options(sea_file, SIZE, coarse, settings=PATIENT))) as running:
        hands.glide(running, 0.2)
        yield running


def taken(running):
    """Whether a tour steers the submarine."""
    return running.tours.timer.touring and running.tick_source.steering.tour is not None


def awaited(running, hands, seconds=AFTER_S):
    """Let this time pass without input."""
    hands.glide(running, seconds + 0.5)


def frame(running):
    """Run one frame; return the hull's distance and change of velocity in it."""
    submarine = running.world.state.submarine
    place, velocity = submarine.position.copy(), submarine.velocity.copy()
    running.frame(TICK_S)
    return (
        np.linalg.norm(submarine.position - place),
        np.linalg.norm(submarine.velocity - velocity),
    )


@pytest.mark.parametrize(
    ("tour", "words"), [("auto", ("mousemove_relative", 30, 5)), ("reef", ("key", "h"))]
)
def test_nobody_is_there_and_then_somebody_is(boat, hands, tour, words):
    boat.tours.name, boat.tours.timer.leaps = tour, tour != "auto"
    hands.point(boat, 0.0, 0.0)
    hands.until(boat, lambda: not boat.tours.timer.touring)
    hands.glide(boat, AFTER_S - 0.5)
    assert not taken(boat)
    boat.overlay.show_help()  # a visitor opened it: it must not cover the tour
    awaited(boat, hands, AFTER_S + 2.0 * DIP_S)
    assert taken(boat)
    hands.glide(boat, 5.0)
    assert boat.overlay.help_opacity == 0.0
    assert np.linalg.norm(boat.world.state.submarine.velocity) > 5.0
    assert boat.overlay.hud.opacity == 0.0
    hands.do(*words)
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


def test_a_visitor_who_rode_a_fish_and_left_is_not_waited_for(boat, hands):
    hands.do("key", "r")
    hands.until(boat, lambda: boat.pilot.riding)
    awaited(boat, hands, AFTER_S + 2.0 * DIP_S)
    assert taken(boat) and not boat.pilot.riding
    hands.do("key", "w")
    hands.until(boat, lambda: not boat.tours.timer.touring)


def test_who_has_opened_the_desk_or_stopped_time_is_left_in_peace(boat, hands):
    for key in ("Tab", "k"):
        hands.do("key", key)
        hands.until(boat, lambda: boat.inspector.open or boat.timeline.paused)
        awaited(boat, hands, AFTER_S + 2.0 * DIP_S)
        assert not boat.tours.timer.touring
        hands.do("key", key)
        hands.until(boat, lambda: not (boat.inspector.open or boat.timeline.paused))
