"""Riding a fish: choosing it, a calm view, and pictures of both eyes in the corners."""

import time
from contextlib import closing

import glfw
import numpy as np
import pytest

from subsea.behavior.table import BEHAVIORS
from subsea.dive.ride import (
    MOST_FISHES,
    MOST_PAN_DEG,
    VALUES,
    Ride,
    coded,
    nearest_to_middle,
    pictured,
    retina_brightness,
    with_insets,
)
from subsea.rendering.gl.id_buffer import FISH, SEABED, WATER, IdMaps
from subsea.scenario.load import load_scenario
from subsea.stage.setup import set_up_theatre
from subsea.submarine.vessel import NEUTRAL
from subsea.ui.dive import Dive
from subsea.ui.overlay import unbroken
from subsea.view.display_rigs import display_rig
from subsea.view.front_screen import text_viewports
from subsea.view.retina import Gaze, eyes_pose
from subsea.view.rig import front, pose_from_angles, seen_part, views
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.windows import User, dive_options

SIZE = (400, 300)


@pytest.fixture(scope="module")
def world():
    world = create_world(load_scenario("peaceful")[0], fish=60)
    for _ in range(20):
        step(world, NEUTRAL)
    return world


def test_the_fish_nearest_to_the_middle_is_chosen(world):
    fishes = world.state.fishes
    rig = display_rig("mono", SIZE)
    eye = np.array([0.0, 0.0, -200.0])
    for chosen in (3, 11):
        before = fishes.position[chosen].copy()
        fishes.position[chosen] = eye + (5.0, 300.0, 4.0)
        (view,) = views(rig, pose_from_angles(eye, np.pi / 2, 0.0))
        assert nearest_to_middle(world, view) == chosen
        (other,) = Ride(world, chosen).views(world, rig, ((0, 0, 8, 6),) * 2, 1.0)[:1]
        assert nearest_to_middle(world, other) != chosen  # the next one
        fishes.alive[chosen] = False
        assert nearest_to_middle(world, view) != chosen
        fishes.alive[chosen], fishes.position[chosen] = True, before


def test_without_a_fish_in_sight_the_nearest_is_chosen(world):
    fishes = world.state.fishes
    (away,) = views(
        display_rig("mono", SIZE), pose_from_angles(np.array([0.0, 0.0, 3000.0]), 0.0, 1.2)
    )
    distance = np.linalg.norm(fishes.position - away.eye, axis=1)
    assert nearest_to_middle(world, away) == np.argmin(distance)
    alive = fishes.alive.copy()
    fishes.alive[:] = False
    assert nearest_to_middle(world, away) is None
    fishes.alive[:] = alive


@pytest.mark.nightly
def test_the_view_of_a_ride_is_steadier_than_the_head(world):
    world = create_world(load_scenario("peaceful")[0], fish=60)
    rides = [Ride(world, fish) for fish in range(0, 60, 6)]
    swung, followed, apart = [], [], []
    for _ in range(90):
        step(world, NEUTRAL)
        pair = [(eyes_pose(world, r.by, 1.0), r.observer(world, 1.0)) for r in rides]
        swung.append([raw.forward for raw, _ in pair])
        followed.append([calm.forward for _, calm in pair])
        apart.append([np.linalg.norm(raw.eye - calm.eye) for raw, calm in pair])
        for _, calm in pair:
            assert calm.forward @ calm.up == pytest.approx(0.0, abs=1e-9)
            assert np.linalg.norm(calm.forward) == pytest.approx(1.0)
    # Shaking of the view: second differences of its direction.
    shaken = [np.linalg.norm(np.diff(way, 2, axis=0), axis=2).mean() for way in (swung, followed)]
    assert shaken[1] < 0.3 * shaken[0]
    alike = np.sum(np.array(swung) * followed, axis=2)
    assert np.median(alike) > 0.95  # but the view follows ...
    assert np.quantile(alike, 0.02) > 0.1  # ... even most sharp turns
    assert np.mean(apart) < 3.0


def test_a_ride_begins_level(world):
    fishes = world.state.fishes
    before, tick = fishes.orientation[5].copy(), world.state.tick
    rolled = np.cos(0.4), np.sin(0.4), 0.0, 0.0  # 46° to a side, about the way it heads
    fishes.orientation[5] = fishes.previous_orientation[5] = rolled
    ride = Ride(world, 5)
    for then in (tick, tick + 1000, 2):
        world.state.tick = then
        calm = ride.observer(world, 1.0)
        assert calm.forward == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)
        assert calm.up == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)
    world.state.tick += 30
    assert ride.observer(world, 1.0).up[2] < 0.95  # and the view rolls with it
    fishes.orientation[5] = fishes.previous_orientation[5] = before
    world.state.tick = tick


def test_the_gaze_turns_up_to_its_limits(world):
    ride = Ride(world, 5)
    ride.turn_gaze(1.0, -0.5, 0.5)
    assert ride.gaze.pan_deg > 10.0 > 0.0 > ride.gaze.tilt_deg
    ride.turn_gaze(1.0, 0.0, 60.0)
    assert ride.gaze.pan_deg == MOST_PAN_DEG
    assert "gaze +120°" in ride.text(world, "range")


def test_words_are_fit_for_children_on_a_public_screen(world):
    ride, minds = Ride(world, 5), world.state.minds
    before = int(minds.intention[5])
    minds.intention[5] = next(k for k, one in enumerate(BEHAVIORS) if one.name == "mate")
    assert "mate   " in ride.text(world, "colours") and "libido " in ride.text(world, "colours")
    text = ride.text(world, "colours", public=True)
    assert "court   " in text and "love " in text and "libido" not in text
    minds.intention[5] = before


@pytest.mark.parametrize("display", ["mono", "side-by-side", "top-bottom", "anaglyph", "dome"])
def test_insets_keep_their_shape_over_every_picture(display):
    rig = display_rig(display, SIZE)
    more, insets = with_insets(rig)
    assert more.outputs == rig.outputs
    assert more.eyes == rig.eyes
    added = more.patches[len(rig.patches) :]
    frames, pictures = added[::2], added[1::2]
    assert len(frames) == len(pictures) == 2 * len(rig.patches)
    for frame, patch in zip(frames, pictures, strict=True):  # a line around it, and below it
        assert frame.mask is not None
        assert np.subtract(patch.place[:2], frame.place[:2]).tolist() == [1, 1]
        assert np.subtract(frame.place[2:], patch.place[2:]).tolist() == [2, 2]
    for k, patch in enumerate(pictures):
        under = rig.patches[k // 2]
        assert patch.left == patch.right == insets[k % 2]
        x, y, width, height = patch.place
        left, bottom, across, up = seen_part(under)
        assert left < x < x + width < left + across
        assert bottom + 0.4 * up < y < y + height < bottom + up
        shape = width * under.squeezed[0] / (height * under.squeezed[1])
        assert shape == pytest.approx(4 / 3, rel=0.05)
    assert insets[0][1] == insets[1][1] == rig.canvas[1]
    assert insets[0][0] + insets[0][2] == insets[1][0]
    assert more.canvas[1] == rig.canvas[1] + insets[0][3]


def test_insets_avoid_the_overlap_of_projectors():
    rig = set_up_theatre("three-projectors", shrink=4).rig
    more, _ = with_insets(rig)
    ahead = front(rig)
    x, _, width, _ = seen_part(ahead)
    assert x >= 36  # 40 pixels overlap on either side; the last ones are almost black
    assert 250 <= width <= ahead.place[2] - 36 - x
    added = more.patches[len(rig.patches) :]
    assert len(added) == 4
    for patch in added:
        assert patch.output == ahead.output
        assert x < patch.place[0]
        assert patch.place[0] + patch.place[2] < x + width
    (viewport,) = text_viewports(rig, lambda page: None)
    assert (viewport.x, viewport.width) == (x / 360, width / 360)
    assert not viewport.squeezed


def test_the_eye_separation_of_a_ride_is_that_of_the_fish(world):
    ride = Ride(world, 5)
    one, other = ride.views(world, display_rig("side-by-side", SIZE), (), 1.0)
    assert np.linalg.norm(one.eye - other.eye) == pytest.approx(2 * ride.by.half_cm, rel=1e-6)
    assert 2 * ride.by.half_cm < 6.4


def test_instruments_wrap_between_their_parts():
    parts = ["depth\u00a02\u00a0m", "", "", "full\u00a0stop"]
    assert unbroken("depth 2 m   full stop").split(" ") == parts


def test_maps_become_colours_and_greys():
    seen = IdMaps(
        np.array([[FISH, SEABED, WATER]], np.uint8), np.array([[7, 0, 0]], np.int32),
        np.array([[50.0, 400.0, np.inf]], np.float32),
    )  # fmt: skip
    np.testing.assert_array_equal(
        pictured(seen, "identity"), coded(np.array([[VALUES["fish"] + 7, VALUES["seabed"], 0]]))
    )
    many = seen._replace(number=np.where(seen.kind == FISH, MOST_FISHES + 7, 0).astype(np.int32))
    np.testing.assert_array_equal(pictured(many, "identity"), pictured(seen, "identity"))
    grey = pictured(seen, "range")[0, :, 0]
    assert grey[0] > grey[1] > grey[2] == 0


@pytest.fixture(scope="module")
def boat(display, quiet):
    with closing(Dive(dive_options(quiet, SIZE, "low"))) as running:
        yield running


def corner(running):
    """The left eye's picture on the display."""
    return whole(running, 0.01)[12:80, 12:105]


@pytest.fixture
def ride(boat):
    """The ride of a visitor that leaves the fish at the end."""
    User.do("key", "r")
    User.until(boat, lambda: boat.pilot.riding)
    yield boat.picture.ride
    User.do("key", "Escape")
    User.until(boat, lambda: not boat.pilot.riding)


def resize(boat, size):
    glfw.set_window_size(boat.window.handle, *size)
    User.until(boat, lambda: boat.window.size == size)


@pytest.mark.nightly
def test_keys_control_a_ride(boat):
    User.do("key", "r")
    User.until(boat, lambda: boat.pilot.riding)
    User.until(boat, lambda: boat.overlay.help_opacity == 0.0)  # a ride counts as under way
    first = boat.picture.ride.by.fish
    colours = corner(boat)
    beside = np.asarray(boat.picture.renderer.rig.canvas) - boat.picture.rig.canvas
    assert beside[1] > 60
    User.do("keydown", "Right")
    User.until(boat, lambda: boat.picture.ride.gaze.pan_deg > 20.0)
    User.do("keyup", "Right")
    User.do("key", "i")
    User.until(boat, lambda: boat.picture.colours == "identity")
    codes = {tuple(code) for code in coded(np.arange(2**16)).tolist()}
    found = corner(boat).reshape(-1, 3)
    assert np.mean([tuple(pixel) in codes for pixel in found.tolist()]) > 0.99
    User.do("key", "i")
    User.until(boat, lambda: boat.picture.colours == "range")
    grey = corner(boat)
    assert np.abs(grey - colours).mean() > 10.0
    assert (np.ptp(grey, axis=2) <= 1).mean() > 0.99
    User.do("key", "r")
    User.until(boat, lambda: boat.picture.ride.by.fish != first)
    User.do("key", "Escape")
    User.until(boat, lambda: not boat.pilot.riding)
    assert boat.window.open
    assert boat.picture.renderer.rig is boat.picture.rig


@pytest.fixture
def see_brightness(boat):
    boat.see_brightness, boat.picture.colours = True, "colours"
    yield
    assert not boat.world.seen_light
    boat.see_brightness = False


def test_a_ridden_fish_senses_the_light_ahead_of_it(boat, see_brightness, ride):
    fish, minds = ride.by.fish, boat.world.state.minds
    for gaze in (Gaze(0.0, 60.0), Gaze(0.0, -60.0)):
        ride.gaze = gaze
        ahead = retina_brightness(boat.picture.renderer, boat.world, ride.by)
        assert 0.05 < ahead < 0.95
        boat.frame(0.1)
        assert boat.world.seen_light[fish] == ahead
        assert minds.light[fish] == pytest.approx(ahead)
    assert boat.world.seen_light.keys() == {fish}
    assert (corner(boat).max(axis=-1) > 0).mean() > 0.9  # the picture itself still shows


def words(running):
    """A mask (h, w) of the pixels of letters, which are bright on a dark ground."""
    with_text = whole(running)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running.overlay, "draw", lambda *rest: None)
        without = whole(running)
    return (with_text - without).max(axis=2) > 60


def whole(running, elapsed_s=0.0):
    for _ in range(2):
        running.frame(elapsed_s)
    time.sleep(0.2)
    return User.screen(running)


@pytest.mark.nightly
def test_help_and_pattern_hide_the_insets_of_a_ride(boat, ride):
    User.until(boat, lambda: boat.picture.insets)
    User.do("key", "h")
    User.until(boat, lambda: boat.overlay.help_opacity == 1.0)
    assert not boat.picture.insets
    assert boat.picture.renderer.rig is boat.picture.rig
    User.do("key", "t")
    User.until(boat, lambda: boat.picture.pattern)
    assert not words(boat).any()
    pattern = whole(boat)
    User.do("key", "h", "p")  # neither help nor instruments
    User.until(boat, lambda: boat.picture.quality_text == "picture medium")
    np.testing.assert_array_equal(whole(boat), pattern)
    User.do("key", "t")
    User.until(boat, lambda: not boat.picture.pattern)
    assert boat.picture.ride is ride
    User.do("key", "h")
    User.until(boat, lambda: boat.overlay.help_opacity == 0.0)
    boat.frame(0.1)
    assert boat.picture.insets
    User.do("key", "p", "p", "p", "p")
    User.until(boat, lambda: boat.picture.quality_text == "picture low")


def test_long_lines_wrap(boat, ride):
    ride.gaze, boat.picture.colours = Gaze(30.0, 20.0), "identity"  # reported too
    for size, lines in (((240, 180), 2), ((700, 300), 1)):
        resize(boat, size)
        User.until(boat, lambda: boat.overlay.help_opacity == 0.0)
        found = words(boat)
        rows = found.any(axis=1).astype(int)
        assert (np.diff(rows, prepend=0) == 1).sum() >= lines
        columns = np.flatnonzero(found.any(axis=0))
        assert columns[0] >= 8
        assert columns[-1] < size[0] - 8
    boat.picture.colours = "colours"
    resize(boat, SIZE)


def test_a_window_can_be_resized_during_a_ride(boat, ride):
    for size in ((240, 180), SIZE):
        resize(boat, size)
        boat.frame(0.1)
        assert boat.picture.renderer.rig.outputs == (size,)
        assert len(boat.picture.renderer.rig.patches) == 5  # the sea, two pictures and their frames


def test_a_ride_ends_when_the_fish_is_eaten(boat):
    User.do("key", "r")
    User.until(boat, lambda: boat.pilot.riding)
    boat.world.state.fishes.alive[boat.picture.ride.by.fish] = False
    User.until(boat, lambda: not boat.pilot.riding)
    assert boat.picture.ride is None
