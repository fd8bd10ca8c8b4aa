"""Pictures in windows: assignment, order, and the window that waits for its display."""

import time
from contextlib import ExitStack, closing

import numpy as np
import pytest

from subsea.dive.pilot import Pilot
from subsea.ui import window_set as walls
from subsea.ui.monitors import Screen, on_display
from subsea.ui.window_set import WindowSet
from tests.support.windows import display_pixels

SIZE = (64, 48)
PLACES = ((0, 0), (64, 0), (128, 0))
COLOURS = ((250, 20, 30), (40, 240, 50), (60, 70, 230))
SCREENS = [(Screen(f"screen {k}", SIZE, place), None) for k, place in enumerate(PLACES)]


@pytest.fixture
def make(display):
    """Opens a set of three windows; closes all at the end."""
    with ExitStack() as stack:
        stack.enter_context(on_display())
        yield lambda **options: stack.enter_context(closing(WindowSet(SCREENS, Pilot(), **options)))


def plain(wall, colour):
    """A texture of one colour in the context of all drawing."""
    data = np.tile(np.array([*colour, 255], np.uint8), (SIZE[1], SIZE[0], 1)).tobytes()
    return wall.context.texture(SIZE, 4, data)


def seen():
    """The middle pixel of each place."""
    time.sleep(0.2)
    picture = display_pixels()
    return [tuple(picture[y + 24, x + 32].tolist()) for x, y in PLACES]


@pytest.mark.parametrize("front", [0, 1, 2])
def test_each_window_shows_its_own_picture_for_any_front_window(make, front):
    wall = make(front=front)
    assert wall.front is wall.windows[front]
    textures = {(k, 0): plain(wall, colour) for k, colour in enumerate(COLOURS)}
    for _ in range(2):
        wall.show(textures)
        wall.present()
    assert seen() == list(COLOURS)
    turned = {(k, 0): textures[(k + 1) % 3, 0] for k in range(3)}
    wall.show(turned)
    wall.present()
    assert seen() == [*COLOURS[1:], COLOURS[0]]


def test_the_picture_of_each_eye_goes_to_the_buffer_chosen_for_it(make, monkeypatch):
    chosen = []

    def choose(number):
        if handle_of(walls.glfw.get_current_context()) == handle_of(wall.front.handle):
            chosen.append((number, middle(wall)))

    monkeypatch.setattr(walls, "one_page", choose)
    wall = make()
    textures = {(0, 0): plain(wall, COLOURS[0]), (0, 1): plain(wall, COLOURS[1])}
    textures |= {(k, page): textures[0, page] for k in (1, 2) for page in (0, 1)}
    wall.show(textures)
    assert [number for number, _ in chosen] == [0, 1]
    assert chosen[1][1] == COLOURS[0]  # the left one was drawn before the right one
    assert middle(wall) == COLOURS[1]


def middle(wall):
    data = wall.context.screen.read((32, 24, 1, 1), components=3)
    return tuple(data)


def test_only_the_last_window_waits_for_its_display(make, monkeypatch):
    waits, swapped = {}, []
    swap = walls.glfw.swap_buffers
    monkeypatch.setattr(
        walls.glfw,
        "swap_interval",
        lambda n: waits.update({handle_of(walls.glfw.get_current_context()): n}),
    )
    wall = make(front=1)
    monkeypatch.setattr(
        walls.glfw,
        "swap_buffers",
        lambda handle: (swapped.append(handle_of(handle)), swap(handle)),
    )
    wall.present()
    assert len(swapped) == 3
    assert [waits[handle] for handle in swapped] == [0, 0, 1]


def handle_of(window):
    import ctypes

    return ctypes.cast(window, ctypes.c_void_p).value


def test_closing_any_window_closes_all(make):
    wall = make()
    assert wall.open
    wall.windows[2].ask_to_close()
    assert not wall.open


def test_all_windows_darken_alike(make):
    wall = make(front=1)
    wall.show({(k, 0): plain(wall, colour) for k, colour in enumerate(COLOURS)})
    wall.darken((0.0, 0.0, 0.0, 0.5))
    wall.present()
    halves = np.array(COLOURS) / 2
    np.testing.assert_allclose(seen(), halves, atol=2)
