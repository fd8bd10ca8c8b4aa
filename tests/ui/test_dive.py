"""The dive in a real window, steered by real mouse events."""

import math
import os
import subprocess
import time
from contextlib import closing

import numpy as np
import pytest
from PIL import ImageGrab

from subsea.ui.dive import Dive
from tests.support.windows import dive_options

SIZE = (320, 240)
FRAME_S = 0.1  # three ticks a picture: the tests check the hull, not smoothness


@pytest.fixture(scope="module")
def boat(display, quiet):
    with closing(Dive(dive_options(quiet, SIZE))) as running:
        glide(running, 0.2)
        yield running


def hands(*words):
    """Move the mouse or press keys by xdotool; return when the display has processed it."""
    subprocess.run(["xdotool", *map(str, words)], check=True, timeout=60)


def glide(running, seconds):
    """Run frames for `seconds` of the dive's own time."""
    for _ in range(round(seconds / FRAME_S)):
        running.frame(FRAME_S)


def until(running, true):
    """Run frames until the display has delivered the input."""
    end = time.monotonic() + 60.0
    while not true() and time.monotonic() < end:
        running.frame(FRAME_S)
        time.sleep(0.01)
    assert true()


def point(running, x, y):
    """Move the pointer, in two steps, to a place given in [-1, 1] from the middle."""
    import glfw

    left, top = glfw.get_window_pos(running.window.handle)
    for share in (0.8, 1.0):
        across = left + (1 + share * x) / 2 * SIZE[0]
        down = top + (1 - share * y) / 2 * SIZE[1]
        hands("mousemove", int(across), int(down))
        glide(running, FRAME_S)


def screen(running):
    """The pixels of the window on the display, (h, w, 3)."""
    import glfw

    left, top = glfw.get_window_pos(running.window.handle)
    picture = ImageGrab.grab(xdisplay=os.environ["DISPLAY"])
    width, height = running.window.size
    return np.asarray(picture)[top : top + height, left : left + width, :3].astype(int)


def stop(running):
    hands("key", "space")
    until(running, lambda: running.pilot.stopping)
    glide(running, 3.0)
    submarine = running.world.state.submarine
    assert np.linalg.norm(submarine.velocity) < 1.0
    assert abs(submarine.rates[0]) < 0.01


@pytest.mark.parametrize(("x", "sign"), [(-0.8, 1), (0.8, -1)])
def test_it_turns_to_where_the_pointer_is(boat, x, sign):
    stop(boat)
    before = boat.world.state.submarine.angles[0]
    point(boat, x, 0.0)
    glide(boat, 2.5)
    turned = boat.world.state.submarine.angles[0] - before
    assert sign * turned > math.radians(15.0)
    stop(boat)


def test_it_goes_ahead_while_the_button_is_held_and_stops_on_the_wheel(boat):
    stop(boat)
    point(boat, 0.0, 0.0)
    submarine = boat.world.state.submarine
    start = submarine.position.copy()
    hands("mousedown", 1)
    until(boat, lambda: np.linalg.norm(submarine.velocity) > 10.0)
    glide(boat, 2.0)
    assert np.linalg.norm(submarine.position - start) > 60.0
    hands("mouseup", 1)
    glide(boat, 0.5)
    assert np.linalg.norm(submarine.velocity) > 20.0  # inertia
    hands("click", 2)
    until(boat, lambda: boat.pilot.stopping)
    glide(boat, 3.0)
    assert np.linalg.norm(submarine.velocity) < 1.0


def test_the_wheel_sets_a_speed_and_the_right_button_goes_astern(boat):
    stop(boat)
    hands("click", 4, "click", 4)
    until(boat, lambda: boat.pilot.throttle == pytest.approx(0.25))
    hands("mousedown", 3)
    glide(boat, 3.0)
    hands("mouseup", 3)
    submarine = boat.world.state.submarine
    heading = submarine.angles[0]
    assert submarine.velocity[:2] @ (math.cos(heading), math.sin(heading)) < -10.0


def test_keys_steer_too(boat):
    stop(boat)
    before = boat.world.state.submarine.position[2]
    hands("keydown", "e")
    until(boat, lambda: boat.world.state.submarine.velocity[2] > 10.0)
    glide(boat, 2.0)
    hands("keyup", "e")
    assert boat.world.state.submarine.position[2] > before + 20.0
    stop(boat)


def test_a_key_shows_in_the_second_picture_at_the_latest(boat):
    stop(boat)
    glide(boat, 3.0)
    still = [boat.picture.eye.forward]
    hands("keydown", "d")
    end = time.monotonic() + 60.0
    while not boat.pilot.held and time.monotonic() < end:
        still.append(boat.picture.eye.forward)
        boat.frame(1 / 144)  # the last of these is the first after the key arrived
    drift = np.linalg.norm(np.diff(still, axis=0), axis=1)
    boat.frame(1 / 144)
    hands("keyup", "d")
    turned = np.cross(still[-1], boat.picture.eye.forward)[2]
    assert turned < -10.0 * max(*drift, 1e-6)
    stop(boat)


def test_the_help_fades_under_way_and_comes_back(boat):
    stop(boat)
    assert boat.overlay.help_opacity == 0.0  # the submarine moved far in earlier tests
    hands("key", "h")
    until(boat, lambda: boat.overlay.help_opacity == 1.0)
    hands("key", "F1")
    until(boat, lambda: boat.overlay.help_opacity == 0.0)


def test_a_key_goes_through_the_qualities(boat):
    assert boat.picture.quality_text.startswith("picture auto: ")
    for name in ("low", "medium", "high"):
        hands("key", "p")
        until(boat, lambda name=name: boat.picture.quality_text == f"picture {name}")
    hands("key", "p")
    until(boat, lambda: boat.picture.quality_text.startswith("picture auto"))


def test_auto_makes_the_canvas_smaller_where_frames_take_too_long(boat):
    boat.picture.target_ms, usual = 0.5, boat.picture.target_ms
    until(boat, lambda: boat.picture.quality_text.endswith("%"))
    assert screen(boat)[20:-20, 20:-20].std() > 3
    boat.picture.target_ms = usual


def test_the_picture_follows_the_size_of_the_window(boat):
    import glfw

    for size in ((240, 180), (400, 300), SIZE):
        glfw.set_window_size(boat.window.handle, *size)
        until(boat, lambda size=size: boat.window.size == size)
        time.sleep(0.2)
        glide(boat, 0.5)
        picture = screen(boat)
        for corner in (picture[:20, :20], picture[:20, -20:], picture[-20:, -20:]):
            assert corner.max() > 20  # water, not an undrawn black part


def test_a_key_fills_the_screen_and_goes_back(boat):
    for size in ((800, 600), SIZE):
        hands("key", "F11")
        until(boat, lambda size=size: boat.window.size == size)
