"""No input ends or blocks a kiosk, except the operator's key."""

import ctypes
import time
from contextlib import closing

import glfw
import pytest

from subsea.dive.settings import AttractSettings, Settings
from subsea.ui.dive import Dive
from tests.support.windows import dive_options

AFTER_S = 4.0


@pytest.fixture(scope="module")
def exhibit(display, hands, quiet, coarse):
    settings = Settings(attract=AttractSettings(after_min=0.0))
    with closing(
        Dive(dive_options(quiet, (320, 240), coarse, settings=settings, kiosk=True))
    ) as running:
        hands.glide(running, 0.5)
        yield running


class Message(ctypes.Structure):
    """A ClientMessage of Xlib, padded to the largest event."""

    _fields_ = (
        ("kind", ctypes.c_int), ("serial", ctypes.c_ulong), ("sent", ctypes.c_int),
        ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("about", ctypes.c_ulong),
        ("format", ctypes.c_int), ("data", ctypes.c_long * 5), ("rest", ctypes.c_long * 12),
    )  # fmt: skip


def ask_to_close(window):
    """Ask the window to close, as window managers do for a close button or Alt+F4."""
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = ctypes.c_ulong
    display = ctypes.c_void_p(x11.XOpenDisplay(None))
    number = glfw.get_x11_window(window.handle)
    about, what = (
        x11.XInternAtom(display, f"WM_{name}".encode(), 0)
        for name in ("PROTOCOLS", "DELETE_WINDOW")
    )
    message = Message(33, 0, 1, display, number, about, 32)
    message.data[0] = what
    x11.XSendEvent(display, ctypes.c_ulong(number), 0, ctypes.c_long(0), ctypes.byref(message))
    x11.XCloseDisplay(display)


def test_it_fills_the_screen_and_stays(exhibit, hands):
    assert exhibit.window.size == (800, 600)
    ask_to_close(exhibit.window)
    for key in ("Tab", "t", "f", "F11", "p", "k", "u", "alt+F4", "F10", "F12", "ctrl+q", "shift+q"):
        hands.do("key", key)
    hands.glide(exhibit, 1.0)
    time.sleep(0.3)
    hands.glide(exhibit, 0.5)
    assert exhibit.window.open and exhibit.window.size == (800, 600)
    assert (
        not exhibit.inspector.open and not exhibit.picture.pattern and not exhibit.timeline.paused
    )
    assert exhibit.picture.quality == "coarse" and exhibit.overlay.hud.mode == "as needed"
    assert not exhibit.filming


def test_its_menu_has_no_way_out(exhibit, hands):
    hands.do("key", "Escape")
    hands.until(exhibit, lambda: exhibit.menu.open)
    assert [entry.text for entry in exhibit.menu.entries()] == ["Continue", "Scenario", "Help"]
    hands.do("key", "Down", "Return")
    hands.glide(exhibit, 0.5)
    assert exhibit.menu.page == "Scenario"
    assert "Start anew" not in [entry.text for entry in exhibit.menu.entries()]
    hands.do("key", "Escape")
    hands.glide(exhibit, 0.3)
    hands.do("key", "Escape")
    hands.until(exhibit, lambda: not exhibit.menu.open)


def test_the_pointer_hides_while_it_rests(exhibit, hands):
    def mode():
        return glfw.get_input_mode(exhibit.window.handle, glfw.CURSOR)

    hands.do("mousemove_relative", 20, 20)
    hands.until(exhibit, lambda: mode() == glfw.CURSOR_NORMAL)
    hands.glide(exhibit, 4.0)
    assert mode() == glfw.CURSOR_HIDDEN
    hands.do("mousemove_relative", 20, 20)
    hands.until(exhibit, lambda: mode() == glfw.CURSOR_NORMAL)


def test_when_visitors_have_left_all_is_as_at_the_start(exhibit, hands):
    exhibit.open_world(exhibit.scenario, exhibit.source, seed=9)
    hands.do("key", "r")
    hands.until(exhibit, lambda: exhibit.pilot.riding)
    hands.do("key", "Escape")
    hands.until(exhibit, lambda: not exhibit.pilot.riding)
    hands.do("key", "Escape")
    hands.until(exhibit, lambda: exhibit.menu.open)
    exhibit.tours.timer.after_s = AFTER_S
    hands.glide(exhibit, AFTER_S + 3.0)
    assert exhibit.tours.timer.touring and exhibit.tick_source.steering.tour is not None
    assert exhibit.world.state.seed == 1
    assert not exhibit.menu.open and not exhibit.pilot.riding
    hands.do("mousemove_relative", 20, 20)
    hands.until(exhibit, lambda: not exhibit.tours.timer.touring)
    exhibit.tours.timer.after_s = 0.0


def test_it_takes_the_keyboard_back(exhibit, hands):
    other = glfw.create_window(64, 64, "other", None, None)
    try:
        glfw.focus_window(other)
        hands.until(exhibit, lambda: not exhibit.window.focused)
        hands.until(exhibit, lambda: exhibit.window.focused)
    finally:
        glfw.destroy_window(other)
        exhibit.window.make_current()


def test_the_operators_key_leaves_and_elsewhere_the_close_button_does(exhibit, hands):
    exhibit.window.stays = False
    ask_to_close(exhibit.window)
    hands.until(exhibit, lambda: not exhibit.window.open)
    exhibit.window.stays = True
    glfw.set_window_should_close(exhibit.window.handle, False)
    hands.do("key", "ctrl+shift+q")
    hands.until(exhibit, lambda: not exhibit.window.open)
