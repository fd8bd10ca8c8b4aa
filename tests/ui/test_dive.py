"""The dive in a real window, steered by real mouse events."""

import time
from contextlib import closing

import glfw
import numpy as np
import pytest

from subsea.ui.dive import Dive
from subsea.ui.first_picture import FirstPicture
from subsea.ui.gui import MARK
from subsea.ui.open_windows import open_windows
from tests.support.windows import dive_options

SIZE = (320, 240)


class Album(FirstPicture):
    """Keeps first pictures in a list."""

    def __init__(self):
        super().__init__("none")
        self.kept = []

    def keep(self, pixels):
        """Add a picture."""
        self.kept.append(pixels)


@pytest.fixture(scope="module")
def boat(display, user, quiet):
    opening = open_windows("mono", SIZE, first=Album())
    with closing(Dive(dive_options(quiet, SIZE), opening)) as running:
        user.glide(running, 0.2)
        yield running


@pytest.fixture
def rested(boat, user):
    """The dive with its submarine at rest."""
    user.do("key", "space")
    user.until(boat, lambda: boat.pilot.stopping)
    submarine = boat.world.state.submarine
    user.until(boat, lambda: np.linalg.norm(submarine.velocity) < 1.0)
    user.until(boat, lambda: abs(submarine.rates[0]) < 0.01)
    return boat


def test_its_first_picture_is_kept_once(boat):
    (kept,) = boat._opening.first.kept
    assert kept.shape == (*SIZE[::-1], 3) and kept.std() > 5.0


def test_the_wheel_sets_a_speed(rested, user):
    user.point(rested, 0.0, 0.0)
    user.do("click", 4, "click", 4)
    user.until(rested, lambda: rested.pilot.throttle == pytest.approx(0.25))


def test_a_key_shows_in_the_second_picture_at_the_latest(rested, user):
    user.glide(rested, 3.0)
    still = [rested.picture.eye.forward]
    user.do("keydown", "d")
    end = time.monotonic() + 60.0
    while not rested.pilot.held and time.monotonic() < end:
        still.append(rested.picture.eye.forward)
        rested.frame(1 / 144)  # the last of these is the first after the key arrived
    drift = np.linalg.norm(np.diff(still, axis=0), axis=1)
    rested.frame(1 / 144)
    user.do("keyup", "d")
    turned = np.cross(still[-1], rested.picture.eye.forward)[2]
    assert turned < -10.0 * max(*drift, 1e-6)


@pytest.mark.nightly
def test_the_help_fades_under_way_and_comes_back(boat, user):
    user.do("keydown", "w")
    user.until(boat, lambda: boat.overlay.help_opacity == 0.0)
    user.do("keyup", "w")
    user.do("key", "h")
    user.until(boat, lambda: boat.overlay.help_opacity == 1.0)
    user.do("key", "F1")
    user.until(boat, lambda: boat.overlay.help_opacity == 0.0)


def test_the_first_help_leaves_the_middle_free_and_a_key_shows_all(boat, user, monkeypatch):
    def covered():
        boat.frame(0.0)
        boat.frame(0.0)
        return np.abs(user.screen(boat) - bare).max(axis=2) > 30

    monkeypatch.setattr(boat.tick_source, "advance", lambda elapsed_s: 1.0)  # paused time
    overlay = boat.overlay
    overlay.hide_help()
    overlay.help_opacity = overlay.hud.opacity = bare = 0.0
    overlay.hud.mode = "never"
    covered()
    bare = user.screen(boat)
    overlay.greet()
    overlay.help_opacity = 1.0
    greeting = covered()
    middle = slice(SIZE[1] // 4, None), slice(SIZE[0] // 4, None)
    assert not greeting[middle].any() and 0.02 < greeting.mean() < 0.15
    user.do("key", "h")
    user.until(boat, lambda: covered()[middle].mean() > 0.1)
    overlay.hide_help()
    overlay.help_opacity, overlay.hud.mode = 0.0, "as needed"


def test_at_the_edge_of_the_sea_a_sign_shows_the_way_back(rested, user):
    def marked():
        rested.frame(0.0)
        rested.frame(0.0)
        ahead = user.screen(rested)[40:140, 80:240]  # above the instruments
        return (np.abs(ahead - np.multiply(MARK, 255.0)).max(axis=2) < 25).sum()

    submarine = rested.world.state.submarine
    before = submarine.position.copy()
    assert marked() == 0
    submarine.position[:2] = rested.scenario.bounds.radius_cm - 70.0, 0.0
    assert marked() > 15
    submarine.position[:] = before


@pytest.mark.nightly
def test_a_key_goes_through_the_qualities(boat, user):
    assert boat.picture.quality_text.startswith("picture auto: ")
    for name in ("low", "medium", "high", "ultra"):
        user.do("key", "p")
        user.until(boat, lambda name=name: boat.picture.quality_text == f"picture {name}")
    user.do("key", "p")
    user.until(boat, lambda: boat.picture.quality_text.startswith("picture auto"))


def test_auto_makes_the_canvas_smaller_where_frames_take_too_long(boat, user):
    boat.picture.target_ms, usual = 0.5, boat.picture.target_ms
    user.until(boat, lambda: boat.picture.quality_text.endswith("%"))
    assert user.screen(boat)[20:-20, 20:-20].std() > 3
    boat.picture.target_ms = usual


def test_the_picture_follows_the_size_of_the_window(boat, user):
    for size in ((240, 180), (400, 300), SIZE):
        glfw.set_window_size(boat.window.handle, *size)
        user.until(boat, lambda size=size: boat.window.size == size)
        time.sleep(0.2)
        user.glide(boat, 0.5)
        picture = user.screen(boat)
        for corner in (picture[:20, :20], picture[:20, -20:], picture[-20:, -20:]):
            assert corner.max() > 20  # water, not an undrawn black part


def test_a_key_fills_the_screen_and_goes_back(boat, user):
    for size in ((800, 600), SIZE):
        user.do("key", "F11")
        user.until(boat, lambda size=size: boat.window.size == size)
