"""The ten manoeuvres (SMC §8.2) by real mouse and keys, with bindings from a file."""

import ctypes
from contextlib import closing

import glfw
import numpy as np
import pytest

from subsea.dive.settings import CONTROLS, read_settings
from subsea.submarine.vessel import hull_axes
from subsea.ui.dive import Dive
from tests.support.windows import FRAME_S, dive_options

SIZE = (320, 240)

# The usual keys to rise do nothing here; two other keys do: one alone, one with Ctrl.
SETTINGS = """
[controls]
rise = ["X", "Ctrl+7"]
quality = ["O"]

[display]
quality = "low"
"""


@pytest.fixture(scope="module")
def boat(display, quiet, tmp_path_factory):
    path = tmp_path_factory.mktemp("settings") / "settings.toml"
    path.write_text(SETTINGS)
    settings = read_settings(path)
    options = dive_options(quiet, SIZE, settings.display.quality, settings=settings)
    with closing(Dive(options)) as running:
        running.frame(FRAME_S)
        yield running


@pytest.fixture
def sub(boat, user):
    """The submarine at rest in open water, without held inputs."""
    user.point(boat, 0.0, 0.0)
    boat.pilot.full_stop()
    submarine = boat.world.state.submarine
    start = boat.scenario.submarine
    submarine.position[:] = start.position_cm
    submarine.angles[:] = 0.3, 0.0
    submarine.velocity[:], submarine.rates[:] = 0.0, 0.0
    return submarine


def ahead(sub):
    return float(hull_axes(*sub.angles)[0] @ sub.velocity)


# Inputs of each manoeuvre: press, place of the pointer, release.
MOUSE = {
    "accelerate": (("mousedown", 1), (), ("mouseup", 1)),
    "reverse": (("mousedown", 3), (), ("mouseup", 3)),
    "turn left": ((), (-0.8, 0.0), ()),
    "turn right": ((), (0.8, 0.0), ()),
    "pitch up": ((), (0.0, 0.8), ()),
    "pitch down": ((), (0.0, -0.8), ()),
    "rise": (("mousedown", 1, "mousedown", 3), (0.0, 0.8), ("mouseup", 1, "mouseup", 3)),
    "dive": (("mousedown", 1, "mousedown", 3), (0.0, -0.8), ("mouseup", 1, "mouseup", 3)),
}
KEYS = {
    "accelerate": "w",
    "reverse": "s",
    "turn left": "a",
    "turn right": "Right",
    "pitch up": "Up",
    "pitch down": "Down",
    "rise": "x",
    "dive": "q",
}
TRUE = {
    "accelerate": lambda sub: ahead(sub) > 25.0,
    "reverse": lambda sub: ahead(sub) < -15.0,
    "turn left": lambda sub: sub.angles[0] > 0.4,
    "turn right": lambda sub: sub.angles[0] < 0.2,
    "pitch up": lambda sub: sub.angles[1] > 0.15,
    "pitch down": lambda sub: sub.angles[1] < -0.15,
    "rise": lambda sub: sub.velocity[2] > 15.0 and abs(sub.angles[1]) < 0.1,
    "dive": lambda sub: sub.velocity[2] < -15.0 and abs(sub.angles[1]) < 0.1,
}


def others(sub, manoeuvre):
    """The other manoeuvres that an input causes: none, if correct."""
    return [name for name, true in TRUE.items() if name != manoeuvre and true(sub)]


@pytest.mark.parametrize("manoeuvre", TRUE)
def test_by_mouse(boat, sub, user, manoeuvre):
    down, place, up = MOUSE[manoeuvre]
    if down:
        user.do(*down)
    if place:
        user.point(boat, *place)
    user.until(boat, lambda: TRUE[manoeuvre](sub))
    assert others(sub, manoeuvre) == []
    if up:
        user.do(*up)


@pytest.mark.parametrize("manoeuvre", TRUE)
def test_by_key(boat, sub, user, manoeuvre):
    user.do("keydown", KEYS[manoeuvre])
    user.until(boat, lambda: TRUE[manoeuvre](sub))
    assert others(sub, manoeuvre) == []
    user.do("keyup", KEYS[manoeuvre])
    user.until(boat, lambda: boat.pilot.held == {})


@pytest.mark.parametrize(
    ("down", "up", "stop"),
    [
        pytest.param(("mousedown", 1), ("mouseup", 1), ("click", 2), id="mouse"),
        pytest.param(
            ("keydown", "w"), ("keyup", "w"), ("key", "space"), id="keys", marks=pytest.mark.nightly
        ),
    ],
)
def test_decelerating_is_letting_go_and_a_full_stop_is_a_full_stop(boat, sub, user, down, up, stop):
    user.do(*down)
    user.until(boat, lambda: ahead(sub) > 60.0)
    user.do(*up)
    user.until(boat, lambda: boat.pilot.held == {})
    user.glide(boat, 10 * FRAME_S)
    slower = ahead(sub)
    assert 15.0 < slower < 60.0  # inertia: not at once
    boat.frame(FRAME_S)
    assert ahead(sub) < slower
    user.do(*stop)
    user.until(boat, lambda: boat.pilot.stopping)
    user.until(boat, lambda: np.linalg.norm(sub.velocity) < 1.0)


def test_the_settings_file_replaces_the_usual_keys(boat, sub, user):
    user.do("keydown", "e")
    user.glide(boat, 10 * FRAME_S)
    assert boat.pilot.held == {}
    assert others(sub, "") == []
    user.do("keyup", "e", "keydown", "ctrl", "keydown", "7")
    user.until(boat, lambda: TRUE["rise"](sub))
    user.do("keyup", "ctrl", "keyup", "7")  # in this order: the key alone does nothing
    user.until(boat, lambda: boat.pilot.held == {})
    before = boat.picture.quality_text
    user.do("key", "p")
    user.do("key", "o")
    user.until(boat, lambda: boat.picture.quality_text != before)
    assert boat.picture.quality_text == "picture medium"  # one step: the default key did nothing
    assert CONTROLS["quality"].inputs == ("P",)


class Ear:
    """A listener that starts to consume keys at some moment, as a text field does."""

    def __init__(self, listener):
        self.listener, self.keys = listener, []

    def __getattr__(self, name):
        return getattr(self.listener, name)

    def keyed(self, key, down, modifiers):
        self.keys.append((key, down))
        return True


def forget_focus():
    """Take the keyboard from all windows, as another program would."""
    x = ctypes.CDLL("libX11.so.6")
    x.XOpenDisplay.restype = ctypes.c_void_p
    there = ctypes.c_void_p(x.XOpenDisplay(None))
    x.XSetInputFocus(there, ctypes.c_ulong(0), 0, ctypes.c_ulong(0))
    x.XCloseDisplay(there)


def test_held_keys_are_released_by_a_listener_or_without_focus(boat, sub, user):
    user.do("keydown", "w")
    user.until(boat, lambda: boat.pilot.held != {})
    usual = boat.window.listener
    boat.window.listener = ear = Ear(usual)
    user.do("key", "a")
    user.do("keyup", "w")
    user.until(boat, lambda: (glfw.KEY_W, False) in ear.keys)
    assert boat.pilot.held == {}
    boat.window.listener = usual
    user.do("keydown", "w")
    user.until(boat, lambda: boat.pilot.held != {})
    own = user.do("getwindowfocus").strip()
    forget_focus()
    user.until(boat, lambda: boat.pilot.held == {})
    user.do("keyup", "w", "windowfocus", own)
    user.until(boat, lambda: boat.window.focused)


def test_a_window_of_one_pixel_is_drawn_and_comes_back(boat, sub, user):
    for size in ((1, 1), (1, 200), SIZE):
        glfw.set_window_size(boat.window.handle, *size)
        user.until(boat, lambda size=size: boat.window.size == size)
        for _ in range(3):
            boat.frame(FRAME_S)
    user.do("key", "h")
    user.until(boat, lambda: boat.overlay.help_opacity > 0.0)


@pytest.mark.nightly
def test_with_a_window_of_one_pixel_and_everything_open_nothing_breaks(boat, sub, user):
    boat.run_command("ride")
    boat.run_command("desk")
    for size in ((1, 1), SIZE):
        glfw.set_window_size(boat.window.handle, *size)
        user.until(boat, lambda size=size: boat.window.size == size)
        for name in ("pattern", "pattern", "look", "help", "menu", "menu"):
            boat.run_command(name)
            boat.frame(FRAME_S)
        for display in ("side-by-side", "dome", "anaglyph", "checkerboard", "mono"):
            boat.picture.show_as(display)
            boat.frame(FRAME_S)
    boat.run_command("alight")
    boat.run_command("desk")
