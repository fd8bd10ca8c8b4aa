"""Time control, and following, steering and picking a fish, in a real window."""

import re
from contextlib import closing

import numpy as np
import pytest

from subsea.behavior.teleop import TeleopCommand
from subsea.geometry.rotation import rotate
from subsea.state import WANDER
from subsea.ui.commands import SHARED_TIME
from subsea.ui.dive import Dive
from subsea.view.retina import Gaze
from subsea.world import snapshot
from subsea.world.world import TICK_S
from tests.support.windows import dive_options

SIZE = (400, 300)


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    with closing(Dive(dive_options(quiet, SIZE, coarse))) as running:
        user.glide(running, 0.2)
        yield running


def pressed(boat, user, key, true):
    user.do("key", key)
    user.until(boat, true)


def heading(world, fish):
    x, y, _ = rotate(world.state.fishes.orientation[fish], (1.0, 0.0, 0.0))
    return np.arctan2(y, x)


@pytest.mark.nightly
def test_keys_pause_and_rewind_time_to_the_same_world(boat, user):
    world, time = boat.world, boat.timeline
    was = {}
    for _ in range(30):
        boat.frame(0.033)
        was[world.state.tick] = snapshot.checksum(world)
    pressed(boat, user, "k", lambda: time.paused)
    now = world.state.tick
    user.glide(boat, 0.5)
    assert (world.state.tick, boat.picture.alpha) == (now, 1.0)
    was[now] = snapshot.checksum(world)
    assert "paused" in boat.text.status
    pressed(boat, user, "comma", lambda: world.state.tick == max(now - 30, time.earliest))
    back = world.state.tick
    assert back in was or back < min(was)
    pressed(boat, user, "period", lambda: world.state.tick == back + 1)
    for tick in sorted(was)[::6]:
        while world.state.tick < tick:
            pressed(boat, user, "period", lambda at=world.state.tick: world.state.tick > at)
        assert snapshot.checksum(world) == was[tick]
    assert "s back" in boat.text.status
    pressed(boat, user, "j", lambda: time.rate == 0.5)
    pressed(boat, user, "l", lambda: time.rate == 1.0)
    pressed(boat, user, "k", lambda: not time.paused)
    user.until(boat, lambda: world.state.tick > now)


def test_a_rewind_of_running_time_says_to_when(boat, user):
    boat.overlay.note("")
    back = max(boat.timeline.tick - round(1.0 / TICK_S), boat.timeline.earliest)
    user.do("key", "comma")
    user.until(boat, lambda: boat.overlay.note_text)
    said = int(re.search(r"back to second (\d+) of the dive", boat.overlay.note_text)[1])
    assert 0 <= said - back * TICK_S + 0.5 < 2.0  # frames went on until the key arrived
    for _ in range(61):
        boat.run_command("rewind")
    assert boat.overlay.note_text.endswith(", the earliest")
    boat.frame(0.0)
    assert boat.timeline.tick == boat.timeline.earliest and not boat.timeline.paused


def test_a_key_switches_between_behind_a_fish_and_its_eyes(boat, user, monkeypatch):
    told = []
    monkeypatch.setattr(boat.overlay, "note", told.append)
    pressed(boat, user, "c", lambda: boat.picture.ride is not None and boat.picture.ride.behind)
    fish = boat.picture.ride.by.fish
    user.glide(boat, 0.3)
    (view,) = boat.picture.views()[:1]
    assert view.without != fish
    assert told == ["C through its eyes   G steer it   Esc leave it"]
    away = boat.world.state.fishes.position[fish] - view.eye
    assert -(view.view[2, :3] @ away) > 0.9 * np.linalg.norm(away)  # it is ahead and visible
    pressed(boat, user, "c", lambda: not boat.picture.ride.behind)
    assert boat.picture.views()[0].without == fish
    pressed(boat, user, "c", lambda: boat.picture.ride.behind)


@pytest.mark.nightly
def test_keys_steer_the_fish_while_the_submarine_keeps_station(boat, user, monkeypatch):
    orders, make = [], boat.timeline.make
    monkeypatch.setattr(boat.timeline, "make", lambda order: (orders.append(order), make(order)))
    if boat.picture.ride is None:  # without the test before
        pressed(boat, user, "c", lambda: boat.picture.ride is not None and boat.picture.ride.behind)
    world, fish = boat.world, boat.picture.ride.by.fish
    submarine, fishes = world.state.submarine, world.state.fishes
    pressed(boat, user, "g", lambda: boat.tick_source.steered_fish == fish)
    user.glide(boat, 3.0)
    station = submarine.position.copy()
    assert "steered by you" in boat.text.status
    assert abs(fishes.goal_speed[fish]) < 0.01  # no command: it hovers
    user.do("keydown", "w", "keydown", "a")
    user.until(boat, lambda: fishes.goal_speed[fish] > 0.5)
    before = heading(world, fish)
    user.glide(boat, 1.0)
    turned = (heading(world, fish) - before + np.pi) % (2 * np.pi) - np.pi
    assert turned > np.radians(20.0)
    assert boat.picture.ride.gaze.pan_deg == 0.0  # keys steer: they do not turn its eyes
    user.do("keyup", "w", "keyup", "a")
    assert world.state.minds.intention[fish] == WANDER
    assert isinstance(orders[-1], TeleopCommand)
    assert np.linalg.norm(submarine.position - station) < 3.0
    pressed(boat, user, "g", lambda: boat.tick_source.steered_fish is None)
    assert "steered by you" not in boat.text.status
    pressed(boat, user, "Escape", lambda: boat.picture.ride is None)
    assert boat.tick_source.steered_fish is None


def test_the_fish_under_the_pointer_is_found(boat, user):
    world = boat.world
    user.glide(boat, 0.2)
    front_view, fishes = boat.picture.front_view, world.state.fishes
    fish = 4
    eye, way = front_view.ray(0.3, 0.4)
    fishes.position[fish] = fishes.previous_position[fish] = eye + 90.0 * way
    boat.timeline.touch()
    boat.timeline.pause()
    boat.frame(0.0)
    x, y = boat.picture.front_view.places(fishes.position[fish][None])[0]
    assert boat.picture.fish_at(x, y) == fish
    assert boat.picture.fish_at(x + 0.45, y + 0.5) != fish
    boat.frame(0.0)  # drawing continues
    assert user.screen(boat).std() > 5.0
    boat.timeline.pause()


def test_a_fish_is_followed_by_its_number(boat, user):
    boat.ride_fish(7, True)
    assert (boat.picture.ride.by.fish, boat.picture.ride.behind) == (7, True)
    boat.frame(0.1)
    boat.run_command("alight")
    assert boat.picture.ride is None


def test_options_begin_a_ride_as_keys_would(boat):
    boat.ride_fish(5, behind=False)
    boat.commands.start_ride((30.0, -10.0), "identity", teleop=True)
    assert boat.picture.ride.gaze == Gaze(30.0, -10.0) and boat.picture.colours == "identity"
    assert boat.steers_fish and boat.tick_source.steered_fish == 5
    boat.commands.set_pace(0.25)
    assert boat.timeline.rate == 0.25 and not boat.timeline.paused
    boat.commands.set_pace(0.0)
    tick = boat.world.state.tick
    boat.frame(1.0)
    assert boat.timeline.paused and boat.world.state.tick == tick
    boat.timeline.pause()
    boat.commands.set_pace(1.0)
    boat.picture.colours = "colours"
    boat.run_command("alight")


def test_an_idle_tour_runs_at_the_usual_pace(boat):
    boat.ride_fish(7, True)
    boat.timeline.run_at(4.0)
    boat.tours.begin()
    assert (boat.picture.ride, boat.timeline.rate) == (None, 1.0)
    boat.tick_source.set_tour(None)
    boat.frame(0.1)


def test_shared_time_cannot_be_stopped(boat, user, monkeypatch):
    monkeypatch.setattr(boat.tick_source, "timeline", None)
    told = []
    monkeypatch.setattr(boat.overlay, "note", told.append)
    for wish in ("pause", "slower", "faster", "tick", "rewind"):
        boat.run_command(wish)
    assert told == [SHARED_TIME] * 5
