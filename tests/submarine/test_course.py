"""Tours: where they lead, what they look at, and what is refused before anybody goes there."""

import math

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.dive.tour import steer_along
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import TourTable
from subsea.state import HULL_CM
from subsea.submarine.vessel import AHEAD_CM_S, check_tours, course_of, rail_at
from subsea.world.build import create_world
from subsea.world.snapshot import checksum
from subsea.world.step import step
from subsea.world.world import TICK_S

PEACEFUL = resource_path("assets/scenarios/peaceful.toml").read_text().split("\n[[tour]]")[0]
NORTH, EAST = (0.0, 500.0, -300.0), (900.0, 0.0, -300.0)


def scenario_with(*waypoints, **more):
    table = {"name": "way", "waypoint": list(waypoints), **more}
    return msgspec.structs.replace(
        load_scenario("peaceful")[0], tour=[msgspec.convert(table, TourTable)]
    )


def point(time_s, x, y=0.0, z=-300.0, **look):
    return {"time_s": time_s, "position_cm": [x, y, z], **look}


@pytest.fixture(scope="module")
def world():
    """Twelve fishes about the submarine."""
    return create_world(load_scenario("peaceful")[0], seed=1, fish=12)


def looks(course, state, t):
    """Heading and pitch in degrees."""
    return np.degrees(rail_at(course, state, t).angles)


def test_it_looks_from_one_thing_to_the_next_with_a_level_start_and_end(world):
    ways = scenario_with(
        point(0.0, 0.0, look_at_cm=NORTH),
        point(10.0, 0.001),  # says nothing about it
        point(20.0, 0.0, look_at_cm=EAST),
    )
    course = course_of(ways, "way")
    headings = np.array([looks(course, world.state, t)[0] for t in np.linspace(0.0, 20.0, 81)])
    assert headings[0] == pytest.approx(90.0, abs=0.1)
    assert headings[40] == pytest.approx(45.0, abs=0.1)
    assert headings[-1] == pytest.approx(0.0, abs=0.1)
    steps = -np.diff(headings)
    assert (steps > 0.0).all()
    assert max(steps[0], steps[-1]) < 0.1 * steps.max()


def test_it_looks_ahead_and_at_the_end_where_it_came_to(world):
    course = course_of(scenario_with(point(0.0, 0.0), point(10.0, 0.0, 400.0, -340.0)), "way")
    for t in (0.0, 5.0, 10.0, 30.0):
        heading, pitch = looks(course, world.state, t)
        assert heading == pytest.approx(90.0)
        assert pitch == pytest.approx(-math.degrees(math.atan(0.1)), abs=0.1)


def test_it_follows_the_near_ones_of_a_species_and_only_the_living(world):
    fishes = world.state.fishes
    kinds = sorted({shoal.species for shoal in world.scenario.fish})
    school = np.flatnonzero(fishes.species == kinds.index("fusilier"))
    assert len(school) > 3
    course = course_of(scenario_with(point(0.0, 0.0, follow="fusilier"), point(9.0, 1.0)), "way")
    fishes.position[:] = 0.0, -700.0, -300.0  # the others
    fishes.position[school] = 0.0, 300.0, -300.0
    fishes.position[school[0]] = 9000.0, 300.0, -300.0  # one that strayed
    assert looks(course, world.state, 0.0)[0] == pytest.approx(90.0, abs=1.0)
    fishes.alive[school[1:]] = False
    assert looks(course, world.state, 0.0)[0] == pytest.approx(math.degrees(math.atan2(1, 30)))
    fishes.alive[school] = False
    world.state.submarine.angles[:] = 0.3, 0.1
    np.testing.assert_allclose(rail_at(course, world.state, 0.0).angles, (0.3, 0.1))
    fishes.alive[:] = True


def test_a_loop_closes_in_place_and_look(world):
    ways = scenario_with(
        point(0.0, 0.0, look_at_cm=NORTH),
        point(5.0, 100.0),
        point(10.0, 100.0, 100.0, look_at_cm=EAST),
        point(15.0, 0.0),
        loop=True,
    )
    course = course_of(ways, "way")
    for t in (-1e-6, 0.0, 3.0, 14.0):
        one, other = (rail_at(course, world.state, t + s) for s in (15.0, 30.0))
        np.testing.assert_allclose(one.position, other.position, atol=1e-3)
        np.testing.assert_allclose(one.angles, other.angles, atol=1e-6)
    before, after = (rail_at(course, world.state, 15.0 + s) for s in (-1e-4, 1e-4))
    np.testing.assert_allclose(before.velocity, after.velocity, atol=0.1)
    np.testing.assert_allclose(before.angles, after.angles, atol=1e-3)


def faults(sea, *waypoints, **more):
    with pytest.raises(UserError) as fault:
        check_tours(scenario_with(*waypoints, **more), sea, ["`rock[0]`"])
    text = str(fault.value)
    assert text.startswith("`tour[0]` 'way' ")
    assert fault.value.key.startswith("tour[0]")
    return text


def test_a_tour_keeps_clear_of_all_that_is_in_the_sea_all_the_way(tank):
    rock = [[300.0, 0.0, -300.0, 80.0, 50.0, 60.0, 0.0]]
    sea = tank(pillars=[[0.0, 300.0, 40.0, -100.0]], rocks=rock).sea
    fine = [point(0.0, -200.0), point(5.0, 0.0), point(10.0, 100.0)]
    check_tours(scenario_with(*fine), sea, ["`rock[0]`"])
    text = faults(sea, *fine, point(18.0, 500.0))  # through it, though no waypoint is inside
    assert "`rock[0]`, expected at least 45" in text
    assert "between `waypoint[2]` and `waypoint[3]`" in text
    near = faults(sea, point(0.0, -100.0, z=-44.6), point(9.0, 0.0, z=-44.6))
    assert "is 44.6 cm from the surface, expected at least 45" in near  # rather than 45
    near = faults(sea, point(0.0, -100.0, z=-44.98), point(9.0, 0.0, z=-44.98))
    assert "is 44.9 cm from the surface, expected at least 45" in near  # not 45.0
    text = faults(sea, point(0.0, -100.0, 300.0), point(9.0, 0.0, 240.0))
    assert "`pillar[0]`" in text
    assert "the seabed" in faults(sea, *fine, point(20.0, 100.0, z=-570.0))
    assert "the surface" in faults(sea, *fine, point(20.0, 100.0, z=-30.0))
    assert "the rim of the sea" in faults(sea, *fine, point(40.0, -1290.0))


def test_a_tour_does_not_race(tank):
    rock = [[900.0, 900.0, -600.0, 20.0, 20.0, 20.0, 0.0]]
    text = faults(tank(rocks=rock).sea, point(0.0, 0.0), point(2.0, 300.0))
    assert f"expected at most {AHEAD_CM_S:g}" in text


@pytest.mark.parametrize(
    ("tour", "words"),
    [
        ('name = "a"', ["missing key `waypoint`", "tour[0]"]),
        ('name = "a"\nwaypoint = [{WAY0}]', ["at least 2 values", "tour[0].waypoint"]),
        ('name = "auto"\nwaypoint = [{WAY0}, {WAY9}]', ["tour[0]", "'auto' is taken"]),
        ('name = "a"\nwaypoint = [{WAY9}, {WAY9}]', ["tour[0].waypoint[0].time_s", "expected 0"]),
        ('name = "a"\nwaypoint = [{WAY0}, {WAY0}]', ["waypoint[1].time_s", "more than 0"]),
        (
            'name = "a"\nwaypoint = [{WAY0}, {WAY9, follow = "fuselier"}]',
            ["tour[0].waypoint[1].follow", "did you mean 'fusilier'"],
        ),
        (
            'name = "a"\nwaypoint = [{WAY0}, {WAY9, ahead = true, follow = "fusilier"}]',
            ["tour[0].waypoint[1]", "only one of"],
        ),
        (
            'name = "a"\nwaypoint = [{WAY0}, {WAY9, look_at_cm = [0, 0, 90]}]',
            ["tour[0].waypoint[1].look_at_cm", "outside the sea"],
        ),
        ('name = "a"\nwaypoint = [{WAY0}, {WAY9, loook = 1}]', ["`loook`", "waypoint[1]"]),
        ('name = "a"\nloop = true\nwaypoint = [{WAY0}, {WAY9}]', ["tour[0]", "is a loop"]),
        (
            'name = "a"\nwaypoint = [{time_s = 0, position_cm = [0, 5000, -300]}, {WAY9}]',
            ["tour[0].waypoint[0].position_cm", "outside the sea"],
        ),
    ],
)
def test_a_fault_is_one_line_that_names_file_tour_and_waypoint(tmp_path, tour, words):
    for time_s in (0, 9):
        way = f"time_s = {time_s}, position_cm = [{-400 + time_s}, 0, -300]"
        tour = tour.replace(f"WAY{time_s}", way)
    file = tmp_path / "s.toml"
    file.write_text(f"{PEACEFUL}\n[[tour]]\n{tour}\n")
    with pytest.raises(UserError) as fault:
        load_scenario(str(file))
    text = str(fault.value)
    assert str(file) in text
    for word in words:
        assert word in text


def test_an_unknown_tour_suggests_the_nearest():
    with pytest.raises(UserError, match="unknown tour 'reeef'; did you mean 'reef'"):
        course_of(load_scenario("peaceful")[0], "reeef")


SHIPPED = [("peaceful", "reef"), ("visitors", "lagoon"), ("schooling", "school")]


@pytest.mark.nightly
@pytest.mark.parametrize(("scenario", "tour"), SHIPPED)
def test_shipped_tours_are_comfortable(scenario, tour):
    world = create_world(load_scenario(scenario)[0], fish=20)
    course = course_of(world.scenario, tour)
    assert 40.0 <= course.seconds <= 60.0
    places, speeds = [], []
    for t in np.arange(0.0, course.seconds, 0.2):
        rail = rail_at(course, world.state, float(t))
        places.append(rail.position)
        speeds.append(np.linalg.norm(rail.velocity))
    assert max(speeds) < 100.0
    roots = world.state.seaweed.node.reshape(-1, 3)
    if len(roots):  # no leaf before the eye
        gaps = np.linalg.norm(roots[:, None] - np.array(places)[None, ::3], axis=2)
        assert gaps.min() > HULL_CM


def test_fishes_meet_the_submarine_where_the_tour_takes_it():
    digests = []
    for _ in range(2):
        world = create_world(load_scenario("peaceful")[0], seed=3, fish=12)
        course = course_of(world.scenario, "reef")
        steer = steer_along(world, course)
        np.testing.assert_array_equal(world.state.submarine.position, course.curve.places[0])
        for _ in range(40):
            step(world, steer(world))
        there = rail_at(course, world.state, 40 * TICK_S)
        np.testing.assert_array_equal(world.state.submarine.position, there.position)
        np.testing.assert_array_equal(world.state.submarine.velocity, there.velocity)
        before = rail_at(course, world.state, 39 * TICK_S)
        np.testing.assert_array_equal(world.state.sea.submarine[:3], before.position)
        np.testing.assert_array_equal(world.state.sea.submarine[3:6], before.velocity)
        digests.append(checksum(world))
    assert digests[0] == digests[1]
