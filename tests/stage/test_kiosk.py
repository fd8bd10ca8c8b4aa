"""No input ends or blocks a kiosk, except the operator's key."""

import time
from contextlib import closing

import glfw
import pytest

from subsea.base.language import language
from subsea.dive.settings import COMFORTS, AttractSettings, Settings
from subsea.stage.parts import KioskPart
from subsea.ui.dive import Dive
from tests.support.windows import dive_options, press_close_button

AFTER_S = 2.0


@pytest.fixture(scope="module")
def exhibit(display, user, quiet, coarse):
    settings = Settings(attract=AttractSettings(after_min=0.0))
    with closing(
        Dive(dive_options(quiet, (320, 240), coarse, settings=settings, parts=[KioskPart()]))
    ) as running:
        user.glide(running, 0.5)
        yield running


def ask_to_close(window):
    press_close_button(glfw.get_x11_window(window.handle))


def test_it_fills_the_screen_and_stays(exhibit, user):
    assert exhibit.window.size == (800, 600)
    ask_to_close(exhibit.window)
    for key in ("Tab", "t", "f", "F11", "p", "k", "u", "alt+F4", "F10", "F12", "ctrl+q", "shift+q"):
        user.do("key", key)
    user.glide(exhibit, 1.0)
    time.sleep(0.3)
    user.glide(exhibit, 0.5)
    assert exhibit.window.open and exhibit.window.size == (800, 600)
    assert (
        not exhibit.inspector.open and not exhibit.picture.pattern and not exhibit.timeline.paused
    )
    assert exhibit.picture.quality == "coarse" and exhibit.overlay.hud.mode == "as needed"
    assert not exhibit.shots.filming


def test_its_menu_has_no_way_out(exhibit, user):
    user.do("key", "Escape")
    user.until(exhibit, lambda: exhibit.menu.open)
    names = [entry.text for entry in exhibit.menu.entries()]
    assert names == ["Continue", "Logbook", "Settings", "Scenario", "Help"]
    exhibit.menu.page = "Settings"
    parts = [entry.text for entry in exhibit.menu.entries()]
    assert parts == ["Comfort", "Reading", "Language", "Back"]
    exhibit.menu.page = ""
    user.do("key", "Down", "Down", "Down", "Return")
    user.glide(exhibit, 1.0)  # a frame takes one change of a key
    assert exhibit.menu.page == "Scenario"
    assert "Restart" not in [entry.text for entry in exhibit.menu.entries()]
    user.do("key", "Escape")
    user.glide(exhibit, 0.3)
    user.do("key", "Escape")
    user.until(exhibit, lambda: not exhibit.menu.open)


@pytest.mark.nightly
def test_the_pointer_hides_while_it_rests(exhibit, user):
    def mode():
        return glfw.get_input_mode(exhibit.window.handle, glfw.CURSOR)

    user.do("mousemove_relative", 20, 20)
    user.until(exhibit, lambda: mode() == glfw.CURSOR_NORMAL)
    user.glide(exhibit, 4.0)
    assert mode() == glfw.CURSOR_HIDDEN
    user.do("mousemove_relative", 20, 20)
    user.until(exhibit, lambda: mode() == glfw.CURSOR_NORMAL)


@pytest.mark.nightly
def test_after_visitors_have_left_the_kiosk_restarts(exhibit, user):
    exhibit.open_world(exhibit.scenario, exhibit.source, seed=9)
    exhibit.preferences.set_language("fr")
    exhibit.preferences.set_comfort(COMFORTS["calm"])
    user.do("key", "r")
    user.until(exhibit, lambda: exhibit.pilot.riding)
    user.do("key", "Escape")
    user.until(exhibit, lambda: not exhibit.pilot.riding)
    user.do("key", "Escape")
    user.until(exhibit, lambda: exhibit.menu.open)
    exhibit.tours.timer.after_s = AFTER_S
    user.glide(exhibit, AFTER_S + 3.0)
    assert exhibit.tours.timer.touring and exhibit.tick_source.steering.tour is not None
    assert exhibit.world.state.seed == 1
    assert language() == "en" and exhibit.pilot.settings.comfort == COMFORTS["usual"]
    assert not exhibit.menu.open and not exhibit.pilot.riding
    user.do("mousemove_relative", 20, 20)
    user.until(exhibit, lambda: not exhibit.tours.timer.touring)
    exhibit.tours.timer.after_s = 0.0


def test_it_takes_the_keyboard_back(exhibit, user):
    other = glfw.create_window(64, 64, "other", None, None)
    try:
        glfw.focus_window(other)
        user.until(exhibit, lambda: not exhibit.window.focused)
        user.until(exhibit, lambda: exhibit.window.focused)
    finally:
        glfw.destroy_window(other)
        exhibit.window.make_current()


def test_the_operators_key_leaves_and_elsewhere_the_close_button_does(exhibit, user):
    exhibit.window.stays = False
    ask_to_close(exhibit.window)
    user.until(exhibit, lambda: not exhibit.window.open)
    exhibit.window.stays = True
    glfw.set_window_should_close(exhibit.window.handle, False)
    user.do("key", "ctrl+shift+q")
    user.until(exhibit, lambda: not exhibit.window.open)
