"""A touch screen: a finger steers, and taps choose."""

from contextlib import closing

import msgspec
import pytest

from subsea.dive.pilot import Pilot
from subsea.dive.settings import MouseSettings
from subsea.ui.dive import Dive
from subsea.ui.touch import HOLD_S, Finger
from tests.support.windows import QUIET, dive_options

SIDE = 480.0
TOUCH = msgspec.structs.replace(QUIET, mouse=MouseSettings(touch=True))


@pytest.fixture
def time_s():
    return [0.0]


@pytest.fixture
def finger(time_s):
    return Finger(Pilot(TOUCH), lambda: time_s[0])


def helm(finger):
    for _ in range(60):
        asked = finger._pilot.helm(0.05)
    return asked


def test_a_drag_looks_and_does_not_go(finger, time_s):
    finger.down(100.0, 100.0)
    finger.moved(180.0, 60.0, SIDE)
    time_s[0] = 3.0 * HOLD_S
    finger.update()
    asked = helm(finger)
    assert asked.yaw < -0.2 and asked.pitch > 0.05 and abs(asked.surge) < 1e-3
    finger.up()
    assert not finger.take_tap()
    asked = helm(finger)
    assert abs(asked.yaw) < 0.01 and abs(asked.pitch) < 0.01


def test_a_finger_that_rests_goes_ahead_until_it_is_lifted(finger, time_s):
    finger.down(100.0, 100.0)
    finger.update()
    assert not finger._pilot.held
    time_s[0] = HOLD_S
    finger.update()
    assert helm(finger).surge > 0.9
    finger.moved(220.0, 100.0, SIDE)  # and looks where it is dragged then
    asked = helm(finger)
    assert asked.surge > 0.9 and asked.yaw < -0.2
    finger.up()
    assert not finger._pilot.held and not finger.take_tap()


def test_a_short_touch_is_a_tap_once(finger):
    finger.down(100.0, 100.0)
    finger.moved(102.0, 101.0, SIDE)
    finger.up()
    assert finger.take_tap() and not finger.take_tap()


def test_a_tap_shows_the_card_of_a_fish_and_the_corner_opens_the_menu(
    display, user, quiet, coarse, monkeypatch
):
    with closing(Dive(dive_options(quiet, (640, 480), coarse, settings=TOUCH))) as boat:
        boat.overlay.hide_help()
        user.glide(boat, 1.0)
        monkeypatch.setattr(boat.picture, "fish_at", lambda x, y: 0)
        monkeypatch.setattr(boat.card, "_look", lambda: 0)
        (left, top), submarine = boat.window.position, boat.world.state.submarine
        user.do("mousemove", left + 320, top + 240)
        user.glide(boat, 0.5)
        assert boat.card.fish is None  # a pointer alone chooses nothing
        user.do("click", 1)
        user.until(boat, lambda: boat.card.fish == 0)
        before = submarine.angles[0]
        user.drag(boat, (left + 300, top + 200), (left + 420, top + 200), drop=False)
        user.until(boat, lambda: submarine.angles[0] < before - 0.05)
        user.do("mouseup", 1)
        user.do("mousemove", left + 640 - 30, top + 30)
        user.glide(boat, 0.3)
        user.do("click", 1)
        user.until(boat, lambda: boat.menu.open)
