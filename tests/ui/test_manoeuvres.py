"""The ten manoeuvres (SMC §8.2) by real mouse and keys, with bindings from a file."""

import ctypes
import re
import subprocess
import time
from contextlib import closing

import glfw
import numpy as np
import pytest

from subsea.core.resources import resource_path
from subsea.dive.bindings import CONTROLS
from subsea.dive.settings import read_settings
from subsea.submarine.hull import hull_axes
from subsea.ui.dive import Dive
from tests.support.windows import dive_options

SIZE = (320, 240)
FRAME_S = 0.1

# The usual keys to rise do nothing here; two other keys do: one alone, one with Ctrl.
SETTINGS = """
[controls]
rise = ["X", "Ctrl+7"]
quality = ["O"]

[display]
quality = "low"
"""


@pytest.fixture(scope="module")
def boat(display, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sea")
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    (folder / "quiet.toml").write_text(
        re.sub(r"^number = \d+", "number = 1", text, flags=re.MULTILINE)
    )
    (folder / "settings.toml").write_text(SETTINGS)
    settings = read_settings(folder / "settings.toml")
    made = Dive(
        dive_options(folder / "quiet.toml", SIZE, settings.display.quality, settings=settings)
    )
    with closing(made) as running:
        running.frame(FRAME_S)
        yield running


def hands(*words):
    """Move the mouse or press keys by xdotool; return when the display has processed it."""
    subprocess.run(["xdotool", *map(str, words)], check=True, timeout=60)


def point(running, x, y):
    """Move the pointer to a place in [-1, 1] from the middle, starting elsewhere."""
    left, top = glfw.get_window_pos(running.window.handle)
    for share in (0.5, 1.0):
        across, down = (1 + share * x) / 2 * SIZE[0], (1 - share * y) / 2 * SIZE[1]
        hands("mousemove", int(left + across), int(top + down))
        running.frame(FRAME_S)


def until(running, true, what=""):
    end = time.monotonic() + 60.0
    while not true() and time.monotonic() < end:
        running.frame(FRAME_S)
    assert true(), what


@pytest.fixture
def sub(boat):
    """The submarine at rest in open water, without held inputs."""
    point(boat, 0.0, 0.0)
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
def test_by_mouse(boat, sub, manoeuvre):
    down, place, up = MOUSE[manoeuvre]
    if down:
        hands(*down)
    if place:
        point(boat, *place)
    until(boat, lambda: TRUE[manoeuvre](sub), manoeuvre)
    assert others(sub, manoeuvre) == []
    if up:
        hands(*up)


@pytest.mark.parametrize("manoeuvre", TRUE)
def test_by_key(boat, sub, manoeuvre):
    hands("keydown", KEYS[manoeuvre])
    until(boat, lambda: TRUE[manoeuvre](sub), manoeuvre)
    assert others(sub, manoeuvre) == []
    hands("keyup", KEYS[manoeuvre])
    until(boat, lambda: boat.pilot.held == {})


@pytest.mark.parametrize(
    ("down", "up", "stop"),
    [
        (("mousedown", 1), ("mouseup", 1), ("click", 2)),
        (("keydown", "w"), ("keyup", "w"), ("key", "space")),
    ],
    ids=["mouse", "keys"],
)
def test_decelerating_is_letting_go_and_a_full_stop_is_a_full_stop(boat, sub, down, up, stop):
    hands(*down)
    until(boat, lambda: ahead(sub) > 60.0)
    hands(*up)
    until(boat, lambda: boat.pilot.held == {})
    for _ in range(10):
        boat.frame(FRAME_S)
    slower = ahead(sub)
    assert 15.0 < slower < 60.0  # inertia: not at once
    boat.frame(FRAME_S)
    assert ahead(sub) < slower
    hands(*stop)
    until(boat, lambda: boat.pilot.stopping)
    until(boat, lambda: np.linalg.norm(sub.velocity) < 1.0)


def test_the_file_binds_other_keys_and_takes_the_usual_away(boat, sub):
    hands("keydown", "e")
    for _ in range(10):
        boat.frame(FRAME_S)
    assert boat.pilot.held == {}
    assert others(sub, "") == []
    hands("keyup", "e", "keydown", "ctrl", "keydown", "7")
    until(boat, lambda: TRUE["rise"](sub))
    hands("keyup", "ctrl", "keyup", "7")  # in this order: the key alone does nothing
    until(boat, lambda: boat.pilot.held == {})
    before = boat.picture.quality_text
    hands("key", "p")
    hands("key", "o")
    until(boat, lambda: boat.picture.quality_text != before)
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


def test_what_was_held_is_let_go_though_another_hears_it_or_the_keyboard_is_lost(boat, sub):
    hands("keydown", "w")
    until(boat, lambda: boat.pilot.held != {})
    usual = boat.window.listener
    boat.window.listener = ear = Ear(usual)
    hands("key", "a")
    hands("keyup", "w")
    until(boat, lambda: (glfw.KEY_W, False) in ear.keys)
    assert boat.pilot.held == {}
    boat.window.listener = usual
    hands("keydown", "w")
    until(boat, lambda: boat.pilot.held != {})
    own = subprocess.run(
        ["xdotool", "getwindowfocus"], check=True, capture_output=True, text=True, timeout=60
    ).stdout.strip()
    forget_focus()
    until(boat, lambda: boat.pilot.held == {})
    hands("keyup", "w", "windowfocus", own)
    until(boat, lambda: boat.window.focused)


def test_a_window_of_one_pixel_is_drawn_and_comes_back(boat, sub):
    for size in ((1, 1), (1, 200), SIZE):
        glfw.set_window_size(boat.window.handle, *size)
        until(boat, lambda size=size: boat.window.size == size)
        for _ in range(3):
            boat.frame(FRAME_S)
    hands("key", "h")
    until(boat, lambda: boat.overlay.help_opacity > 0.0)


def test_with_a_window_of_one_pixel_and_everything_open_nothing_breaks(boat, sub):
    boat.run_command("ride")
    boat.run_command("desk")
    for size in ((1, 1), SIZE):
        glfw.set_window_size(boat.window.handle, *size)
        until(boat, lambda size=size: boat.window.size == size)
        for name in ("pattern", "pattern", "look", "help", "menu", "menu"):
            boat.run_command(name)
            boat.frame(FRAME_S)
        for display in ("side-by-side", "dome", "anaglyph", "checkerboard", "mono"):
            boat.picture.show_as(display)
            boat.frame(FRAME_S)
    boat.run_command("alight")
    boat.run_command("desk")
