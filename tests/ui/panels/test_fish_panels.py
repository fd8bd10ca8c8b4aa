"""Panels about fishes and time in a real window, by real mouse events."""

import tomllib
from contextlib import closing

import glfw
import msgspec
import numpy as np
import pytest

from subsea.behavior.table import INTENTIONS
from subsea.dive.minds_text import Chart, feelings, focus
from subsea.scenario.schema import Waypoint
from subsea.state import EAT, ESCAPE, FEAR, NOBODY, SUBMARINE
from subsea.state.feelings import feel
from subsea.ui.dive import Dive
from subsea.ui.gui import LIT
from subsea.ui.panels import PANELS
from subsea.ui.panels.behavior import ChartState
from subsea.ui.panels.control import angles_deg
from subsea.view.retina import Gaze
from subsea.world import snapshot
from subsea.world.world import TICK_S
from tests.support.windows import dive_options

SIZE = (780, 590)


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    with closing(Dive(dive_options(quiet, SIZE, coarse))) as running:
        running.overlay.hide_help()
        user.glide(running, 0.2)
        user.do("key", "Tab")
        user.until(running, lambda: running.inspector.open)
        yield running


@pytest.fixture
def still(boat, user):
    """A dive with paused time, closed panels and no chosen fish."""
    boat.inspector.shown.clear()
    boat.ride_fish(None)
    boat.inspector.chosen = None
    if not boat.timeline.paused:
        boat.timeline.pause()
    user.glide(boat, 0.2)
    return boat


def opened(boat, user, name, fish=None):
    boat.inspector.shown.add(name)
    boat.inspector.chosen = fish
    user.glide(boat, 0.3)


def put(boat, fish, x, y, far_cm):
    """Put a fish at a place on the screen."""
    eye, way = boat.picture.front_view.ray(x, y)
    fishes = boat.world.state.fishes
    fishes.position[fish] = fishes.previous_position[fish] = eye + far_cm * way


def click(boat, user, x, y):
    left, top = boat.window.position
    user.drag(boat, (round(left + x * SIZE[0]), round(top + y * SIZE[1])))


def test_a_click_in_the_sea_chooses_the_fish_that_is_drawn_there(still, user):
    for fish in range(len(still.world.state.fishes.alive)):
        put(still, fish, 0.5, 0.5, -500.0)  # behind the camera
    put(still, 4, 0.3, 0.4, 90.0)
    put(still, 7, 0.7, 0.6, 120.0)
    put(still, 1, 0.7, 0.6, 260.0)  # behind it
    user.glide(still, 0.1)
    click(still, user, 0.3, 0.4)
    assert still.inspector.chosen == 4
    click(still, user, 0.7, 0.6)
    assert still.inspector.chosen == 7
    ringed = user.screen(still)
    still.inspector.chosen = None
    still.frame(0.0)
    plain = user.screen(still)
    still.inspector.chosen = 7
    rows, columns = np.nonzero(np.abs(ringed - plain).sum(axis=2) > 60)  # the ring around it
    assert abs(columns.mean() / SIZE[0] - 0.7) < 0.02 and abs(rows.mean() / SIZE[1] - 0.6) < 0.02
    assert np.hypot(columns - 0.7 * SIZE[0], rows - 0.6 * SIZE[1]).min() > 10.0
    click(still, user, 0.98, 0.96)  # open water
    assert still.inspector.chosen is None


@pytest.mark.nightly
def test_fishes_are_chosen_on_the_panel_one_after_another_or_by_number(still, user, spots):
    opened(still, user, "Habits")
    spots.click(still, "next")
    spots.click(still, "next")
    assert still.inspector.chosen == 1
    spots.click(still, "previous")
    spots.click(still, "previous")
    assert still.inspector.chosen == len(still.world.state.fishes.alive) - 1
    spots.click(still, "fish", 0.2)
    user.do("key", "ctrl+a", "5", "Return")
    user.until(still, lambda: still.inspector.chosen == 5)
    spots.type(still, "fish", "99999")
    assert still.inspector.chosen == 5
    spots.type(still, "fish", "5-1")
    assert still.inspector.chosen == 5
    spots.click(still, "fish", 0.2)
    user.do("key", "ctrl+a", "BackSpace", "Return")
    user.until(still, lambda: still.inspector.chosen is None)


def test_a_dead_fish_is_no_longer_chosen(still, user):
    still.inspector.chosen = 2
    still.world.state.fishes.alive[2] = False
    user.glide(still, 0.1)
    assert still.inspector.chosen is None
    still.world.state.fishes.alive[2] = True


def test_a_slider_changes_the_digestion_of_one_fish_until_a_rewind(still, user, spots):
    time, digestion = still.timeline, still.world.state.minds.digestion
    time.single()
    opened(still, user, "Behavior", 3)
    before, tick = digestion.copy(), time.tick
    time.single()
    user.glide(still, 0.1)
    spots.drag(still, "digestion, 1/s", 0.1, 0.5)
    after = digestion.copy()
    assert after[3] > 2.0 * before[3]
    np.testing.assert_array_equal(np.delete(after, 3), np.delete(before, 3))
    time.stand_at(tick)
    user.glide(still, 0.1)
    np.testing.assert_array_equal(digestion, before)


def test_hunger_and_libido_are_set_now(still, user, spots):
    minds = still.world.state.minds
    opened(still, user, "Behavior", 3)
    spots.click(still, "hunger", 0.02)
    assert minds.mental[3, 0] < 0.1
    assert minds.eaten[3] > 0.85 * minds.appetite[3]
    spots.click(still, "libido", 0.5)
    assert minds.mental[3, 1] > 0.5
    assert minds.last_mating[3] < still.world.state.tick * TICK_S


@pytest.mark.nightly
def test_constants_of_all_fishes_are_set_keep_their_order_and_go_back(still, user, spots):
    opened(still, user, "Behavior")
    before = still.world.nature
    spots.click(still, "Constants of all fishes")
    user.glide(still, 0.2)
    spots.drag(still, "is alarmed by fear of", 0.3, 0.9)
    assert still.world.nature.alarmed > 0.8 > before.alarmed
    assert still.world.nature.panicked > still.world.nature.alarmed
    spots.click(still, "As in the scenario")
    assert still.world.nature == before
    spots.click(still, "Constants of all fishes")


def test_the_highlighted_intention_is_the_current_one(still, user, spots):
    minds = still.world.state.minds
    opened(still, user, "Behavior", 3)
    for code in (ESCAPE, EAT):
        minds.intention[3], minds.target[3] = code, 0
        user.glide(still, 0.2)
        picture = user.screen(still)
        blue = {}
        for name in INTENTIONS:
            x, y = (int(v) for v in spots[name][:2])
            blue[name] = picture[y + 8 : y + 12, x + 4 : x + 8].mean(axis=(0, 1))
        lit = max(blue, key=lambda name: blue[name].sum())
        assert lit == INTENTIONS[code]
        np.testing.assert_allclose(blue[lit], np.multiply(LIT, 255.0), atol=8.0)


def test_the_target_of_a_fish_is_described(still):
    world = still.world
    minds, fishes = world.state.minds, world.state.fishes
    minds.intention[3], minds.predator[3] = ESCAPE, SUBMARINE
    far = np.linalg.norm(fishes.position[3] - world.state.submarine.position)
    assert focus(world, 3) == ("the submarine", pytest.approx(far))
    minds.predator[3] = 8
    assert focus(world, 3)[0] == f"{world.species[fishes.species[8]].name} 8"
    minds.intention[3], minds.target[3] = EAT, -1
    assert focus(world, 3) == ("nothing", None)


def test_charts_hold_what_the_state_had(still, user):
    minds, seen = still.world.state.minds, []
    opened(still, user, "Behavior", 0)
    still.timeline.pause()
    for _ in range(20):
        still.frame(TICK_S)
        seen.append((still.world.state.tick, minds.mental[0].copy()))
    minds.mental[0, FEAR] = 0.625
    still.frame(0.0)
    chart = still.inspector.state(ChartState).chart
    assert isinstance(chart, Chart) and chart.fish == 0
    seen[-1][1][FEAR] = 0.625
    for tick, mental in seen:
        back = still.world.state.tick - tick
        np.testing.assert_array_equal(chart.values[:, -1 - back], mental)


@pytest.mark.nightly
def test_habits_are_set_for_one_fish_or_its_species(still, user, spots):
    minds, fishes = still.world.state.minds, still.world.state.fishes
    opened(still, user, "Habits", 4)
    kin = fishes.species == fishes.species[4]
    male = minds.male.copy()
    spots.click(still, "female" if male[4] else "male", 0.1)
    assert minds.male[4] != male[4]
    np.testing.assert_array_equal(np.delete(minds.male, 4), np.delete(male, 4))
    spots.click(still, "cold", 0.2)
    spots.click(still, "warmth", 0.2)
    assert minds.likes[4].tolist() == [False, False, True, True]
    name = still.world.species[fishes.species[4]].name
    spots.click(still, f"all of {name}", 0.1)
    spots.click(still, "prey" if minds.kind[4] == 0 else "pacifist", 0.1)
    assert len(set(minds.kind[kin])) == 1
    schools = minds.schools.copy()
    spots.click(still, "likes schooling", 0.1)
    assert (minds.schools[kin] != schools[4]).all()
    np.testing.assert_array_equal(minds.schools[~kin], schools[~kin])
    spots.click(still, "this fish alone", 0.1)


def test_the_character_of_a_fish_is_set_and_its_feelings_are_told(still, user, spots):
    minds, fishes = still.world.state.minds, still.world.state.fishes
    opened(still, user, "Habits", 5)
    before = minds.timidity.copy()
    spots.drag(still, "timidity", 0.3, 0.9)
    assert minds.timidity[5] > 2.0
    np.testing.assert_array_equal(np.delete(minds.timidity, 5), np.delete(before, 5))
    assert feelings(still.world, 5) == []
    feel(minds, 5, SUBMARINE, 0.3)
    feel(minds, 5, 8, -0.8)
    name = still.world.species[fishes.species[8]].name
    assert feelings(still.world, 5) == [f"dislikes {name} 8 80%", "likes the submarine 30%"]
    user.glide(still, 0.2)
    minds.liked[5], minds.liking[5] = NOBODY, 0.0


@pytest.mark.nightly
def test_time_is_paused_stepped_and_rewound(still, user, spots):
    time, world = still.timeline, still.world
    opened(still, user, "Time")
    spots.click(still, "go on")
    assert not time.paused
    user.glide(still, 1.5)
    spots.click(still, "pause")
    assert time.paused
    tick, sums = time.tick, snapshot.checksum(world)
    spots.click(still, "one tick")
    assert time.tick == tick + 1
    spots.drag(still, "##back", 0.99, 0.5)
    assert time.tick < tick - 20
    time.stand_at(tick)
    user.glide(still, 0.1)
    assert snapshot.checksum(world) == sums
    spots.click(still, "×2", 0.2)
    assert time.rate == 2.0
    spots.click(still, "×1", 0.2)


@pytest.mark.nightly
def test_diagrams_and_wireframe_are_ticked_and_drawn(still, user, spots):
    opened(still, user, "Control")
    plain = user.screen(still)
    for label in ("bounds", "wireframe"):
        spots.click(still, label, 0.1)
    assert still.picture.diagrams == {"bounds"} and still.picture.wireframe
    user.do("mousemove", 400, 585)
    user.glide(still, 0.2)
    beside = np.abs(user.screen(still) - plain)[:, 560:].sum(axis=2)
    assert (beside > 60).mean() > 0.1
    for label in ("bounds", "wireframe"):
        spots.click(still, label, 0.1)
    assert not still.picture.diagrams and not still.picture.wireframe
    lights = still.world.state.submarine.lights
    spots.click(still, "lights", 0.1)
    assert lights.all()
    spots.click(still, "lights", 0.1)
    assert not lights.any()


def test_the_camera_is_copied_as_a_waypoint_that_a_tour_can_have(still, user, spots):
    submarine = still.world.state.submarine
    opened(still, user, "Control")
    spots.click(still, "copy it as a waypoint of a tour")
    text = glfw.get_clipboard_string(None).decode()
    (entry,) = tomllib.loads(f"waypoint = [{text}]")["waypoint"]
    point = msgspec.convert(entry, Waypoint)
    ahead = np.subtract(point.look_at_cm, point.position_cm)
    np.testing.assert_allclose(point.position_cm, submarine.position, atol=60.0)
    heading, pitch = angles_deg(still.picture.front_view.view)
    level = np.cos(np.radians(pitch)) * np.linalg.norm(ahead)
    expected = [np.cos(np.radians(heading)) * level, np.sin(np.radians(heading)) * level]
    np.testing.assert_allclose(ahead[:2], expected, atol=0.2)


def test_counts_of_the_picture_are_right(still, user):
    opened(still, user, "Control")
    counts = still.picture.counts
    assert counts["fishes"] == np.count_nonzero(still.world.state.fishes.alive)
    assert 0 < counts["in sight"] <= counts["fishes"]
    assert counts["triangles"] == still.picture.renderer.triangles > 1000


@pytest.mark.nightly
def test_a_fish_is_ridden_followed_and_left_and_its_gaze_turned(still, user, spots):
    opened(still, user, "Fish view", 5)
    spots.click(still, "the fish's eyes", 0.1)
    assert still.picture.ride.by.fish == 5 and not still.picture.ride.behind
    assert still.picture.insets
    spots.drag(still, "pan", 0.42, 0.7)
    assert still.picture.ride.gaze.pan_deg > 30.0 and still.picture.ride.gaze.tilt_deg == 0.0
    spots.click(still, "look ahead")
    assert still.picture.ride.gaze == Gaze()
    spots.click(still, "identity", 0.1)
    assert still.picture.colours == "identity"
    spots.click(still, "colours", 0.1)
    spots.click(still, "pictures of both eyes", 0.1)
    assert not still.picture.insets
    spots.click(still, "pictures of both eyes", 0.1)
    spots.click(still, "behind the fish", 0.1)
    assert still.picture.ride.behind
    spots.click(still, "next")
    assert still.picture.ride.by.fish == still.inspector.chosen == 6 and still.picture.ride.behind
    spots.click(still, "steer this fish", 0.05)
    assert still.steers_fish
    spots.click(still, "goes by the light in its eyes", 0.05)
    still.timeline.single()
    user.glide(still, 0.2)
    assert set(still.world.seen_light) == {6}
    spots.click(still, "goes by the light in its eyes", 0.05)
    assert not still.world.seen_light
    spots.click(still, "the submarine", 0.1)
    assert still.picture.ride is None and still.inspector.chosen == 6


@pytest.mark.nightly
def test_panels_that_nobody_touches_change_nothing(still, user):
    time, world = still.timeline, still.world
    user.do("mousemove", 400, 585)
    time.pause()
    user.glide(still, 0.5)  # earlier input has no further effect
    time.pause()
    begin, sums = time.tick, []
    for panels in ((), PANELS):
        still.inspector.shown = set(panels)
        still.inspector.chosen = 3 if panels else None
        time.stand_at(begin)
        user.glide(still, 0.1)
        assert time.tick == begin
        time.pause()
        while time.tick < begin + 12:
            still.frame(TICK_S / 2)
        time.pause()
        sums.append(snapshot.checksum(world))
    assert sums[0] == sums[1]
