"""The tour that begins when nobody is there, and a kiosk: with real hands in a real window."""

import re
from contextlib import closing

import msgspec
import numpy as np
import pytest

from subsea.core.errors import UserError
from subsea.core.resources import resource_path
from subsea.dive.bindings import WISHES
from subsea.dive.settings import DEFAULTS, Settings
from subsea.dive.settings import AttractSettings as AttractSettings
from subsea.dive.settings import KioskSettings as KioskSettings
from subsea.submarine.hull import ACCELERATION_CM_S2
from subsea.ui.attract import DIP_S, Attract, tour_named
from subsea.ui.dive import Dive
from subsea.ui.kiosk import ALLOWED, locked
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
    """Whether a tour takes the submarine along."""
    return running.attract.touring and running._crew._course.tour is not None


def awaited(running, hands, seconds=AFTER_S):
    """Let so much time pass without a hand."""
    hands.glide(running, seconds + 0.5)


def test_it_begins_after_idle_time_and_ends_with_any_input():
    attract = Attract(10.0, leaps=False)
    done = [attract.look(False, 1.0) for _ in range(12)]
    assert done.count("begin") == 1 and done[9] == "begin"
    assert attract.look(True, 1.0) == "end" and not attract.touring
    assert attract.look(True, 100.0) is None
    assert [attract.look(False, 9.0), attract.look(False, 0.9)] == [None, None]
    assert attract.look(False, 100.0, may=False) is None
    assert attract.look(False, 0.1) == "begin"
    never = Attract(0.0, leaps=False)
    assert never.look(False, 1e6) is None


def test_before_a_tour_that_begins_elsewhere_it_gets_dark_and_a_hand_makes_it_light_again():
    attract = Attract(10.0, leaps=True)
    assert attract.look(False, 10.0 - DIP_S / 2.0) is None and attract.shade == 0.0
    assert attract.look(False, DIP_S / 2.0) is None and attract.shade == 0.5
    assert attract.look(True, DIP_S / 4.0) is None and attract.shade == 0.25
    assert attract.look(False, 10.0) == "begin" and attract.shade == 1.0
    assert attract.look(False, DIP_S) is None and attract.shade == 0.0


def frame(running):
    """One picture; how far the hull went in it, and by how much its velocity changed."""
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
    boat._taken, boat.attract.leaps = tour_named(tour), tour != "auto"
    hands.point(boat, 0.0, 0.0)
    hands.until(boat, lambda: not boat.attract.touring)
    hands.glide(boat, AFTER_S - 0.5)
    assert not taken(boat)
    boat.overlay.show_help()  # somebody had asked for it: on the tour it would be in the way
    awaited(boat, hands, AFTER_S + 2.0 * DIP_S)
    assert taken(boat)
    hands.glide(boat, 5.0)
    assert boat.overlay.help_opacity == 0.0
    assert np.linalg.norm(boat.world.state.submarine.velocity) > 5.0
    assert boat.overlay.hud.opacity == 0.0
    hands.do(*words)
    for _ in range(200):
        touring = boat.attract.touring
        gone, faster = frame(boat)
        assert gone < 5.0
        if touring != boat.attract.touring:
            assert boat._crew._course.tour is None  # in the very same picture
            assert faster < 1.5 * ACCELERATION_CM_S2 * TICK_S
            break
    assert not boat.attract.touring
    for _ in range(60):
        gone, faster = frame(boat)
        assert gone < 5.0 and faster < 1.5 * ACCELERATION_CM_S2 * TICK_S
    assert boat.overlay.help_opacity > 0.9  # for who has just come


def test_a_visitor_who_rode_a_fish_and_left_is_not_waited_for(boat, hands):
    hands.do("key", "r")
    hands.until(boat, lambda: boat.pilot.riding)
    awaited(boat, hands, AFTER_S + 2.0 * DIP_S)
    assert taken(boat) and not boat.pilot.riding
    hands.do("key", "w")
    hands.until(boat, lambda: not boat.attract.touring)


def test_who_has_opened_the_desk_or_stopped_time_is_left_in_peace(boat, hands):
    for key in ("Tab", "k"):
        hands.do("key", key)
        hands.until(boat, lambda: boat.desk.open or boat.timeline.paused)
        awaited(boat, hands, AFTER_S + 2.0 * DIP_S)
        assert not boat.attract.touring
        hands.do("key", key)
        hands.until(boat, lambda: not (boat.desk.open or boat.timeline.paused))


def test_a_kiosk_has_inputs_for_what_cannot_strand_it_only():
    found = locked(DEFAULTS).bindings
    assert found.key(ord("Q"), 2 | 1) == "leave"
    assert found.key(ord("Q"), 0) == "dive"
    for wish in WISHES:
        assert bool(found.inputs(wish)) == (wish in ALLOWED)
    assert locked(with_key("F12")).bindings.meaning("F12") == "leave"  # no visitor's input


@pytest.mark.parametrize(
    ("key", "controls", "rival"), [("F9", {"ride": ["F9"]}, "ride"), ("w", {}, "ahead")]
)
def test_the_operators_key_is_none_that_visitors_use(key, controls, rival):
    name = key.upper()
    with pytest.raises(UserError, match=f"--kiosk: '{name}' .* '{rival}', at `kiosk.leave`"):
        locked(with_key(key, **controls))


def with_key(key, **controls):
    return msgspec.structs.replace(DEFAULTS, controls=controls, kiosk=KioskSettings(leave=key))
