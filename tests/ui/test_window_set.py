"""One dive in three real windows side by side, with input in each of them."""

import math
import time
from contextlib import closing

import glfw
import msgspec
import numpy as np
import pytest

from subsea.frame.packet import pack
from subsea.ui import picture
from subsea.ui.dive import Dive
from subsea.ui.monitors import Installation, Screen
from subsea.view.camera import NEAR_CM, off_axis
from subsea.view.rig import CameraRig, DisplayPatch, Eye, views
from subsea.view.structured_light import UNIFORM, light_patterns, light_picture
from subsea.view.test_pattern import lineup
from tests.support.windows import FRAME_S, ShownOn, display_pixels, dive_options

SIZE = (240, 180)
NAMES = ("left", "front", "right")
PLACES = ((20, 40), (260, 40), (500, 40))
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
def boat(display, user, quiet):
    wall = ShownOn(Installation(THREE, SCREENS))
    with closing(Dive(dive_options(quiet, SIZE, "low", parts=[wall]))) as running:
        user.glide(running, 0.3)
        yield running


def point(running, user, x, y):
    """Move the pointer, in two steps, to a pixel of the display."""
    for step in (3, 0):
        user.do("mousemove", x + step, y)
        running.frame(FRAME_S)


def shown(running, text=False):
    """The pixels of all windows on the display, (h, w, 3)."""
    draw = running.overlay.draw
    if not text:
        running.overlay.draw = lambda *rest: None
    for _ in range(2):
        running.frame(0.0)
    running.overlay.draw = draw
    time.sleep(0.2)
    (left, top), (width, height) = PLACES[0], SIZE
    return display_pixels()[top : top + height, left : left + 3 * width]


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


def test_text_viewports_are_computed_once(boat, user, monkeypatch):
    found = []
    monkeypatch.setattr(picture, "text_viewports", lambda *given: found.append(given))
    user.glide(boat, 0.3)
    assert not found


def test_help_is_in_the_front_window_only(boat):
    change = np.abs(shown(boat, text=True) - shown(boat))
    changed = [part.max() for part in np.split(change, 3, axis=1)]
    assert changed[1] > 60
    assert max(changed[0], changed[2]) < 20


@pytest.mark.nightly
def test_a_key_in_another_window_steers(boat, user):
    for number in (0, 2):
        depth = boat.world.state.submarine.position[2]
        focus(boat, user, number)
        user.do("keydown", "e")
        user.until(boat, lambda: boat.world.state.submarine.velocity[2] > 10.0)
        user.do("keyup", "e")
        assert boat.world.state.submarine.position[2] > depth
        user.do("key", "space")
        user.until(boat, lambda: boat.pilot.stopping)
        user.glide(boat, 2.0)


def focus(running, user, number):
    found = user.do("search", "--name", f"^{NAMES[number]}$")
    user.do("windowfocus", "--sync", found.split()[0])
    running.frame(FRAME_S)


def test_the_pointer_steers_from_the_middle_of_the_front_window_to_the_edges_of_all(boat, user):
    (left, top), (width, height) = PLACES[0], SIZE
    pilot = boat.pilot
    for x, y, share in (
        (left + 1.5 * width, top + height / 2, (0.0, 0.0)),
        (left + 0.75 * width, top + height / 2, (-0.5, 0.0)),  # in the left window
        (left + 2.25 * width, top + height / 4, (0.5, 0.5)),  # in the right one
    ):
        point(boat, user, round(x), round(y))
        user.until(
            boat,
            lambda share=share: np.allclose(pilot.pointer or (9, 9), share, atol=0.02),
        )
    heading = boat.world.state.submarine.angles[0]
    point(boat, user, round(left + 2.8 * width), round(top + height / 2))
    user.glide(boat, 2.5)
    assert boat.world.state.submarine.angles[0] < heading - 0.2
    point(boat, user, 700, 500)  # outside the windows
    user.until(boat, lambda: pilot.pointer is None)


def test_the_pointer_steers_on_where_it_crosses_a_seam(boat, user):
    left, top = PLACES[0]
    left_at = []
    leave, boat.pilot.pointer_left = boat.pilot.pointer_left, lambda: left_at.append(1)
    for x in range(left + SIZE[0] - 20, left + SIZE[0] + 20, 5):
        user.do("mousemove", x, top + 90)
        boat.frame(FRAME_S)
    boat.pilot.pointer_left = leave
    assert not left_at


@pytest.mark.nightly
def test_a_key_shows_the_pattern_in_every_window_and_the_sea_again(boat, user):
    before = shown(boat)
    focus(boat, user, 2)
    user.do("key", "t")
    user.until(boat, lambda: boat.picture.pattern)
    np.testing.assert_allclose(shown(boat), lineup(THREE), atol=1)
    user.do("key", "p")  # the canvas is rebuilt, the pattern stays
    user.until(boat, lambda: boat.picture.quality_text == "picture medium")
    np.testing.assert_allclose(shown(boat), lineup(THREE), atol=1)
    user.do("key", "t")
    user.until(boat, lambda: not boat.picture.pattern)
    assert np.abs(shown(boat) - before).mean() < 10.0


def test_structured_light_comes_from_one_projector_pixel_by_pixel(boat, monkeypatch):
    before = shown(boat)
    number = len(UNIFORM) + 6  # of a pattern of columns
    light = 1, number
    (part, *_) = boat.parts
    monkeypatch.setattr(part, "over", lambda over: msgspec.structs.replace(over, light=light))
    left, front, right = np.split(shown(boat), 3, axis=1)
    assert not left.any() and not right.any()
    stripes = light_picture(light_patterns(SIZE)[number], SIZE)
    np.testing.assert_allclose(front, stripes, atol=1)
    light = 2, 0
    left, front, right = np.split(shown(boat), 3, axis=1)
    assert right.min() >= 254 and not left.any() and not front.any()
    monkeypatch.undo()
    assert np.abs(shown(boat) - before).mean() < 10.0


def test_a_window_of_another_size_shows_the_same_picture_stretched(boat, user):
    pattern = lineup(THREE)[:, : SIZE[0]]
    user.do("key", "t")
    user.until(boat, lambda: boat.picture.pattern)
    window = boat.window_set.windows[0]
    glfw.set_window_size(window.handle, SIZE[0] // 2, SIZE[1] // 2)
    user.until(boat, lambda: window.size == (SIZE[0] // 2, SIZE[1] // 2))
    small = shown(boat)[: SIZE[1] // 2, : SIZE[0] // 2]
    means = pattern.reshape(SIZE[1] // 2, 2, SIZE[0] // 2, 2, 3).mean(axis=(1, 3))
    assert np.abs(small - means).mean() < 3.0
    glfw.set_window_size(window.handle, *SIZE)
    user.until(boat, lambda: window.size == SIZE)
    user.do("key", "t")
    user.until(boat, lambda: not boat.picture.pattern)


def test_the_full_screen_key_leaves_windows_with_a_place_alone(boat, user):
    user.do("key", "F11")
    for _ in range(5):
        boat.frame(FRAME_S)
        time.sleep(0.05)
    assert [window.size for window in boat.window_set.windows] == [SIZE] * 3


def test_escape_in_any_window_opens_the_menu_and_its_last_entry_leaves(boat, user):
    focus(boat, user, 0)
    user.do("key", "Escape")
    user.until(boat, lambda: boat.menu.open)
    for _ in range(4):  # quality, scenario, help, leave: for unchangeable windows
        user.do("key", "Down")
        for _ in range(4):
            boat.frame(FRAME_S)
    user.do("key", "Return")
    user.until(boat, lambda: not boat.window_set.open)
