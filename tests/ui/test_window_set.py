"""One dive in three real windows side by side, with input in each of them."""

import math
import os
import re
import subprocess
import time
from contextlib import closing

import numpy as np
import pytest
from PIL import ImageGrab

from subsea.core.resources import resource_path
from subsea.frame.packet import pack
from subsea.ui import picture
from subsea.ui.dive import Dive
from subsea.ui.monitors import Installation, Screen
from subsea.view.camera import NEAR_CM, off_axis
from subsea.view.rig import CameraRig, DisplayPatch, Eye, views
from subsea.view.theatre.lineup import lineup
from tests.support.windows import dive_options

SIZE = (240, 180)
NAMES = ("left", "front", "right")
PLACES = ((20, 40), (260, 40), (500, 40))
FRAME_S = 0.1
TOP = NEAR_CM * math.tan(math.radians(25.0))


def flat_wall(columns, size, outputs):
    """A flat 4:1 screen in columns before the observer, with one output each or one for all."""
    width, height = size
    wide = TOP * columns * width / height
    eyes, patches = [], []
    for k in range(columns):
        part = (k * width, 0, width, height)
        place = (0, 0, width, height) if outputs > 1 else part
        left = wide * (2.0 * k / columns - 1.0)
        eyes.append(
            Eye(
                part,
                np.zeros(3),
                np.eye(3),
                off_axis(left, left + 2.0 * wide / columns, -TOP, TOP),
            )
        )
        patches.append(DisplayPatch(place, part, part, output=k if outputs > 1 else 0, channel=k))
    sizes = (size,) * columns if outputs > 1 else ((columns * width, height),)
    return CameraRig((columns * width, height), sizes, tuple(eyes), tuple(patches))


THREE = flat_wall(3, SIZE, 3)
ONE = flat_wall(1, (3 * SIZE[0], SIZE[1]), 1)
SCREENS = tuple(Screen(name, SIZE, place) for name, place in zip(NAMES, PLACES, strict=True))


@pytest.fixture(scope="module")
def sea(tmp_path_factory):
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    path = tmp_path_factory.mktemp("sea") / "quiet.toml"
    path.write_text(re.sub(r"^number = \d+", "number = 2", text, flags=re.MULTILINE))
    return str(path)


@pytest.fixture(scope="module")
def boat(display, sea):
    installation = Installation(THREE, SCREENS)
    with closing(Dive(dive_options(sea, SIZE, "low"), installation)) as running:
        glide(running, 0.3)
        yield running


def hands(*words):
    subprocess.run(["xdotool", *map(str, words)], check=True, timeout=60)


def glide(running, seconds):
    for _ in range(round(seconds / FRAME_S)):
        running.frame(FRAME_S)


def until(running, true):
    end = time.monotonic() + 60.0
    while not true() and time.monotonic() < end:
        running.frame(FRAME_S)
        time.sleep(0.01)
    assert true()


def point(running, x, y):
    """Move the pointer, in two steps, to a pixel of the display."""
    for step in (3, 0):
        hands("mousemove", x + step, y)
        running.frame(FRAME_S)


def shown(running):
    """The pixels of all windows on the display, (h, w, 3), without text."""
    draw, running.overlay.draw = running.overlay.draw, lambda *rest: None
    for _ in range(2):
        running.frame(0.0)
    running.overlay.draw = draw
    time.sleep(0.2)
    picture = ImageGrab.grab(xdisplay=os.environ["DISPLAY"])
    (left, top), (width, height) = PLACES[0], SIZE
    return np.asarray(picture)[top : top + height, left : left + 3 * width, :3].astype(int)


def in_one(running):
    """The same moment as one wide picture by the same renderer."""
    renderer, alpha = running.picture.renderer, running.picture.alpha
    renderer.arrange(ONE)
    quality = renderer.quality
    packet = pack(
        running.world, views(ONE, running.picture.eye), alpha,
        options=quality.packing,
    )  # fmt: skip
    renderer.draw(packet)
    picture = renderer.read_pixels().astype(int)
    renderer.arrange(THREE)
    return picture


def test_three_windows_show_one_continuous_picture(boat):
    picture, whole = shown(boat), in_one(boat)
    assert picture.std() > 5
    off = np.abs(picture - whole)
    assert off.mean() < 1.0
    for seam in (SIZE[0], 2 * SIZE[0]):
        near = off[:, seam - 3 : seam + 3]
        assert np.percentile(near, 95) <= 3  # except a particle cut by the edge


def test_where_text_goes_is_found_once(boat, monkeypatch):
    found = []
    monkeypatch.setattr(picture, "text_viewports", lambda *given: found.append(given))
    glide(boat, 0.3)
    assert not found


def test_help_is_in_the_front_window_only(boat):
    with_text = [grab(boat, k) for k in range(3)]
    boat.overlay.draw, draw = lambda *rest: None, boat.overlay.draw
    without = [grab(boat, k) for k in range(3)]
    boat.overlay.draw = draw
    changed = [np.abs(a - b).max() for a, b in zip(with_text, without, strict=True)]
    assert changed[1] > 60
    assert max(changed[0], changed[2]) < 20


def grab(running, number):
    for _ in range(2):
        running.frame(0.0)
    time.sleep(0.2)
    (left, top), (width, height) = PLACES[number], SIZE
    picture = ImageGrab.grab(xdisplay=os.environ["DISPLAY"])
    return np.asarray(picture)[top : top + height, left : left + width, :3].astype(int)


def test_a_key_in_another_window_steers(boat):
    for number in (0, 2):
        depth = boat.world.state.submarine.position[2]
        focus(boat, number)
        hands("keydown", "e")
        until(boat, lambda: boat.world.state.submarine.velocity[2] > 10.0)
        hands("keyup", "e")
        assert boat.world.state.submarine.position[2] > depth
        hands("key", "space")
        until(boat, lambda: boat.pilot.stopping)
        glide(boat, 2.0)


def focus(running, number):
    found = subprocess.run(
        ["xdotool", "search", "--name", f"^{NAMES[number]}$"],
        capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    hands("windowfocus", "--sync", found.stdout.split()[0])
    running.frame(FRAME_S)


def test_the_pointer_steers_from_the_middle_of_the_front_window_to_the_edges_of_the_wall(boat):
    (left, top), (width, height) = PLACES[0], SIZE
    pilot = boat.pilot
    for x, y, share in (
        (left + 1.5 * width, top + height / 2, (0.0, 0.0)),
        (left + 0.75 * width, top + height / 2, (-0.5, 0.0)),  # in the left window
        (left + 2.25 * width, top + height / 4, (0.5, 0.5)),  # in the right one
    ):
        point(boat, round(x), round(y))
        until(
            boat,
            lambda share=share: np.allclose(pilot.pointer or (9, 9), share, atol=0.02),
        )
    heading = boat.world.state.submarine.angles[0]
    point(boat, round(left + 2.8 * width), round(top + height / 2))
    glide(boat, 2.5)
    assert boat.world.state.submarine.angles[0] < heading - 0.2
    point(boat, 700, 500)  # outside the windows
    until(boat, lambda: pilot.pointer is None)


def test_the_helm_is_not_let_go_where_the_pointer_crosses_a_seam(boat):
    left, top = PLACES[0]
    left_at = []
    leave, boat.pilot.pointer_left = boat.pilot.pointer_left, lambda: left_at.append(1)
    for x in range(left + SIZE[0] - 20, left + SIZE[0] + 20, 5):
        hands("mousemove", x, top + 90)
        boat.frame(FRAME_S)
    boat.pilot.pointer_left = leave
    assert not left_at


def test_a_key_shows_the_pattern_in_every_window_and_the_sea_again(boat):
    before = shown(boat)
    focus(boat, 2)
    hands("key", "t")
    until(boat, lambda: boat.picture.pattern)
    np.testing.assert_allclose(shown(boat), lineup(THREE), atol=1)
    hands("key", "p")  # the canvas is rebuilt, the pattern stays
    until(boat, lambda: boat.picture.quality_text == "picture medium")
    np.testing.assert_allclose(shown(boat), lineup(THREE), atol=1)
    hands("key", "t")
    until(boat, lambda: not boat.picture.pattern)
    assert np.abs(shown(boat) - before).mean() < 10.0


def test_a_window_of_another_size_shows_the_same_picture_stretched(boat):
    import glfw

    pattern = lineup(THREE)[:, : SIZE[0]]
    hands("key", "t")
    until(boat, lambda: boat.picture.pattern)
    window = boat.window_set.windows[0]
    glfw.set_window_size(window.handle, SIZE[0] // 2, SIZE[1] // 2)
    until(boat, lambda: window.size == (SIZE[0] // 2, SIZE[1] // 2))
    small = shown(boat)[: SIZE[1] // 2, : SIZE[0] // 2]
    means = pattern.reshape(SIZE[1] // 2, 2, SIZE[0] // 2, 2, 3).mean(axis=(1, 3))
    assert np.abs(small - means).mean() < 3.0
    glfw.set_window_size(window.handle, *SIZE)
    until(boat, lambda: window.size == SIZE)
    hands("key", "t")
    until(boat, lambda: not boat.picture.pattern)


def test_the_full_screen_key_leaves_windows_with_a_place_alone(boat):
    hands("key", "F11")
    for _ in range(5):
        boat.frame(FRAME_S)
        time.sleep(0.05)
    assert [window.size for window in boat.window_set.windows] == [SIZE] * 3


def test_escape_in_any_window_opens_the_menu_from_which_the_dive_is_left(boat):
    focus(boat, 0)
    hands("key", "Escape")
    until(boat, lambda: boat.menu.open)
    for _ in range(4):  # quality, scenario, help, leave: for unchangeable windows
        hands("key", "Down")
        for _ in range(4):
            boat.frame(FRAME_S)
    hands("key", "Return")
    until(boat, lambda: not boat.window_set.open)
