"""Cameras cued by directions: places, ways, and obstacles."""

import signal

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.dive.camera_way import hidden
from subsea.dive.directed_camera import check_tour, directed_steering, is_cut, is_over
from subsea.dive.pilot import Pilot
from subsea.dive.tick_source import LocalTicks
from subsea.geometry.rotation import matrix
from subsea.geometry.solids import height_at
from subsea.geometry.vector import vector
from subsea.habitat.contact import clearance
from subsea.media.film import directed_length_s
from subsea.scenario.directions import Camera
from subsea.scenario.load import load_scenario, scenario_file
from subsea.stage.cluster.messages import encode, from_master, picture_of, ticks_of
from subsea.state import HULL_CM
from subsea.submarine.vessel import (
    ACCELERATION_CM_S2,
    AHEAD_CM_S,
    NEUTRAL,
    STATION,
    Helm,
    Rail,
    course_of,
    hull_axes,
    rail_at,
)
from subsea.view.rig import CameraPose
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S
from tests.support.daily import examples
from tests.support.scenes import scene

CUT = "camera = { follow = { species = 'fusilier' }, over_s = 0.0, distance_cm = 150.0 }"
STILL = "camera = { position_cm = [-400.0, -200.0, -250.0], look_at_cm = [0.0, -200.0, -250.0] }"
BEYOND = "camera = { position_cm = [420.0, 0.0, -250.0], look_at_cm = [700.0, 0.0, -250.0] }"


def world_of(folder, *directions):
    world = create_world(load_scenario(str(scene(folder, *directions)))[0])
    step(world, NEUTRAL)  # as films and dives do before any steering
    return world


def ride(world, seconds, steer=None, each=lambda: None):
    """Let directions steer the submarine; return its places (ticks, 3), cm."""
    steer, places = steer or directed_steering(world), []
    for _ in range(round(seconds / TICK_S)):
        step(world, steer(world))
        places.append(world.state.submarine.position.copy())
        each()
    return np.array(places)


def off(world, target):
    """The angle (degrees) between the submarine's view and a place."""
    boat = world.state.submarine
    way = np.asarray(target) - boat.position
    return np.degrees(np.arccos(hull_axes(*boat.angles)[0] @ way / np.linalg.norm(way)))


def middle(world, species="fusilier"):
    fishes = world.state.fishes
    return fishes.position[fishes.species == world.scenario.species.index(species)].mean(axis=0)


def test_the_camera_keeps_station_before_the_first_cue(tmp_path):
    world = world_of(tmp_path, f"at_s = 1.0\n{CUT}")
    assert directed_steering(world)(world) == STATION
    ride(world, 0.9)
    assert directed_steering(world)(world) == STATION
    ride(world, 0.2)
    assert isinstance(directed_steering(world)(world), Rail)


def test_a_cut_is_immediate_and_then_follows(tmp_path):
    world = world_of(tmp_path, CUT)
    boat = world.state.submarine
    (there,) = ride(world, TICK_S)
    assert (boat.previous_position == boat.position).all()  # no motion between the last two ticks
    assert np.linalg.norm(there - middle(world)) == pytest.approx(150.0, abs=15.0)
    assert off(world, middle(world)) < 3.0
    places = ride(world, 12.0)
    assert np.linalg.norm(middle(world) - there) > 60.0  # they have moved on
    assert np.linalg.norm(places[-1] - middle(world)) == pytest.approx(150.0, abs=40.0)
    assert off(world, middle(world)) < 15.0
    steps = np.diff(places, axis=0) / TICK_S
    assert np.linalg.norm(steps, axis=1).max() < 0.8 * AHEAD_CM_S
    assert np.linalg.norm(np.diff(steps, axis=0), axis=1).max() < ACCELERATION_CM_S2 * TICK_S


def test_a_way_starts_and_ends_smoothly(tmp_path):
    still = STILL.replace("}", ", over_s = 5.0 }")
    world = world_of(tmp_path, still)
    places = ride(world, 9.0)
    steps = np.diff(places, axis=0) / TICK_S
    assert np.linalg.norm(np.diff(steps, axis=0), axis=1).max() < 40.0 * TICK_S
    assert np.linalg.norm(steps[0]) < 3.0 and np.linalg.norm(steps[-1]) < 1.0
    assert np.linalg.norm(places[-1] - (-400.0, -200.0, -250.0)) < 1.0
    gone = np.linalg.norm(places - places[0], axis=1)
    assert gone[round(2.5 / TICK_S)] == pytest.approx(0.5 * gone[-1], rel=0.2)
    assert gone[round(5.0 / TICK_S)] > 0.95 * gone[-1]
    assert off(world, (0.0, -200.0, -250.0)) < 1.0


def test_a_tour_is_joined_from_its_beginning_and_followed_to_its_end(tmp_path):
    world = world_of(tmp_path, "at_s = 1.0\ncamera = { tour = 'glide', over_s = 0.0 }")
    ride(world, 1.0 + 2 * TICK_S)
    course = course_of(world.scenario, "glide")
    began = world.state.directions.began[0]
    for seconds in (0.5, 2.0, 5.0):
        ride(world, seconds)
        gone_s = (world.state.tick - began) * TICK_S
        rail = rail_at(course, world.state, gone_s)
        assert np.linalg.norm(world.state.submarine.position - rail.position) < 2.0


def test_a_camera_behind_looks_in_the_direction_of_travel(tmp_path):
    behind = CUT.replace("}, over_s", "}, behind = true, over_s")
    world = world_of(tmp_path, behind)
    ride(world, 4.0)
    fishes = world.state.fishes
    shown = fishes.species == world.scenario.species.index("fusilier")
    heads = matrix(fishes.orientation[shown])[..., 0].mean(axis=0)
    way = middle(world) - world.state.submarine.position
    level = heads[:2] @ way[:2] / np.linalg.norm(heads[:2]) / np.linalg.norm(way[:2])
    assert level > 0.8


def test_the_camera_follows_the_cast_and_waits_without_one(tmp_path):
    pair = "pair = [4, 5]\ncamera = { follow = 'cast', over_s = 0.0, distance_cm = 130.0 }"
    world = world_of(tmp_path, pair)
    world.state.directions.cast[0] = 4, 5
    ride(world, 1.0)
    assert off(world, middle(world, "clownfish")) < 3.0
    world.state.fishes.alive[[4, 5]] = False
    before = world.state.submarine.angles.copy()
    places = ride(world, 4.0)
    assert np.linalg.norm(places[-1] - places[-30]) < 1.0
    np.testing.assert_allclose(world.state.submarine.angles, before, atol=0.1)


@pytest.mark.nightly
def test_the_camera_avoids_obstacles_on_its_way(tmp_path):
    world = world_of(tmp_path, BEYOND)
    sea, boat = world.state.sea, world.state.submarine
    aim = (420.0, 0.0, -250.0)
    assert hidden(world, aim, vector(boat.position), HULL_CM)
    gaps = []
    ride(world, 22.0, each=lambda: gaps.append(clearance(sea.pillars, sea.rocks, boat.position)))
    assert np.linalg.norm(boat.position - aim) < 2.0
    assert min(gaps) > 0.8 * HULL_CM


def test_the_camera_finds_a_free_line_of_sight(tmp_path):
    world = world_of(tmp_path, CUT)
    world.state.fishes.position[:4] += np.array([580.0, 0.0, 0.0], np.float32)
    world.state.fishes.position[:4, 1] *= 0.2  # just behind the rock, as seen from the start
    ride(world, 2 * TICK_S)
    boat = vector(world.state.submarine.position)
    assert not hidden(world, boat, vector(middle(world)), 5.0)
    assert clearance(world.state.sea.pillars, world.state.sea.rocks, boat) > HULL_CM


@settings(max_examples=examples(3))
@given(
    st.lists(st.tuples(*3 * [st.floats(-1.0, 1.0)]), min_size=1, max_size=3),
    st.lists(st.sampled_from([0.0, 0.5, 3.0]), min_size=3, max_size=3),
)
def test_the_camera_stays_in_free_water(reef, wishes, over):
    world, whole = reef
    snapshot.restore(world, whole)
    sea, boat, bounds = world.state.sea, world.state.submarine, world.scenario.bounds
    before = boat.position.copy()

    def look():
        nonlocal before
        x, y, z = vector(boat.position)
        assert clearance(sea.pillars, sea.rocks, (x, y, z)) > 0.4 * HULL_CM
        assert z > height_at(sea.floor, sea.half_width, x, y) + 0.4 * HULL_CM and z < -0.4 * HULL_CM
        assert np.hypot(x, y) < bounds.radius_cm
        assert np.linalg.norm(boat.position - before) < AHEAD_CM_S * TICK_S + 3.0 or cut
        before = boat.position.copy()

    for k, ((x, y, z), over_s) in enumerate(zip(wishes, over, strict=False)):
        size = np.array([0.6 * bounds.radius_cm, 0.6 * bounds.radius_cm, 0.5 * bounds.depth_cm])
        place = np.array([x, y, z - 1.0]) * size
        cut = over_s == 0.0
        camera = Camera(position_cm=tuple(place), look_at_cm=(0.0, 0.0, -300.0), over_s=over_s)
        cues = [msgspec.structs.replace(one, camera=camera) for one in world.scenario.direction]
        world.scenario = msgspec.structs.replace(world.scenario, direction=cues)
        world.state.directions.began[:] = -1
        world.state.directions.began[k] = world.state.tick - 1
        ride(world, 2.5, each=look)


@pytest.fixture(scope="module")
def reef(tmp_path_factory):
    """A bay full of rocks with three cameras to be placed by tests, and its initial state."""
    text = tmp_path_factory.mktemp("reef") / "reef.toml"
    far = "camera = { position_cm = [-430.0, -60.0, -330.0], look_at_cm = [0.0, 0.0, -300.0] }"
    cues = "".join(f"[[direction]]\nat_s = 9999.0\n{far}\n" for _ in range(3))
    text.write_text(scenario_file("peaceful").read_text() + cues)
    world = create_world(load_scenario(str(text))[0], fish=2)
    step(world, NEUTRAL)
    return world, snapshot.take(world)


def test_only_a_cut_is_a_leap():
    eye = CameraPose(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    swum = eye._replace(eye=np.array([AHEAD_CM_S, 0.0, 0.0]))
    assert not is_cut(eye, swum, 1.0) and is_cut(eye, swum, 1 / 30)
    assert not is_cut(None, swum, 1.0)


def test_rewinding_over_cuts_restores_equal_worlds(tmp_path):
    late = f"at_s = 1.5\n{STILL.replace('}', ', over_s = 0.0 }')}"
    world = world_of(tmp_path, CUT, late, "at_s = 2.5\n" + BEYOND + "\nlights = true")
    ticks = LocalTicks(world, Pilot(), directed_steering(world))
    sums = {}
    while world.state.tick < 130:
        ticks.advance(TICK_S)
        sums[world.state.tick] = snapshot.checksum(world)
    for tick in (100, 20, 60, 47, 46):
        ticks.timeline.go(tick)
        assert snapshot.checksum(world) == sums[tick]
    assert not world.state.submarine.lights[0]
    # Further play calls the tour again, which depends on the world alone.
    while world.state.tick < 130:
        ticks.advance(TICK_S)
        assert snapshot.checksum(world) == sums[world.state.tick]


def test_the_camera_returns_gently_after_manual_steering(tmp_path):
    world = world_of(tmp_path, CUT)
    ride(world, 1.0)
    for _ in range(150):
        step(world, Helm(surge=1.0, yaw=0.4))
    places = ride(world, 8.0)
    steps = np.diff(places, axis=0) / TICK_S
    assert np.linalg.norm(np.diff(steps, axis=0), axis=1).max() < 1.1 * ACCELERATION_CM_S2 * TICK_S
    assert np.linalg.norm(places[-1] - middle(world)) == pytest.approx(150.0, abs=40.0)


def test_messages_carry_cuts():
    rail = Rail(np.array([1.0, 2.0, -3.0]), np.zeros(3), (0.5, 0.1), True)
    sent = from_master(encode(picture_of(1, 7, 0.5, [rail, rail._replace(cut=False)], "")))
    assert [one.cut for one in ticks_of(sent)] == [True, False]
    np.testing.assert_array_equal(ticks_of(sent)[0].position, rail.position)


def test_a_film_ends_with_a_direction_or_when_all_was_shown(tmp_path):
    world = world_of(tmp_path, CUT, "at_s = 1.0\nend = true")
    ride(world, 0.9)
    assert not is_over(world)
    ride(world, 0.2)
    assert is_over(world)
    lasting = f"{CUT}\nfor_s = 1.0", "at_s = 0.5\ncaption = 'There.'\nfor_s = 2.0"
    world = world_of(tmp_path, *lasting, f"every_s = 0.5\n{STILL}")
    ride(world, 2.4)
    assert not is_over(world)
    ride(world, 0.2)
    assert is_over(world)
    loaded = load_scenario(str(scene(tmp_path, *lasting)))
    assert directed_length_s(loaded, None) == pytest.approx(2.5, abs=0.1)


def test_ctrl_c_interrupts_the_compilation_of_a_rehearsal(tmp_path, monkeypatch):
    def ready(*given):
        signal.raise_signal(signal.SIGINT)
        pytest.fail("compiled on")

    monkeypatch.setattr("subsea.media.film.ready_world", ready)
    loaded = load_scenario(str(scene(tmp_path, CUT)))
    with pytest.raises(KeyboardInterrupt):
        directed_length_s(loaded, None)


def test_an_endless_film_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("subsea.media.film.MAX_DIRECTED_S", 1.0)
    event = "event = 'eaten'\nend = true"
    loaded = load_scenario(str(scene(tmp_path, CUT, event)))
    with pytest.raises(UserError, match=r"scene\.toml: its directions are not over after .*--sec"):
        directed_length_s(loaded, None)


def test_the_directed_tour_needs_a_camera_and_its_name_is_reserved(tmp_path):
    scenario = load_scenario(str(scene(tmp_path, CUT))).scenario
    for name in ("auto", "directed", "glide"):
        check_tour(scenario, name)
    with pytest.raises(UserError, match=r"no \[\[direction\]\] of this scenario has a `camera`"):
        check_tour(load_scenario("peaceful")[0], "directed")
    with pytest.raises(UserError, match="did you mean 'glide'"):
        check_tour(scenario, "glade")
    with pytest.raises(UserError, match=r"`tour\[0\]`: the name 'directed' is taken"):
        load_scenario(str(scene(tmp_path)), ["tour.0.name=directed"])
