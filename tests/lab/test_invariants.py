"""Every broken invariant is found; an intact world has no faults."""

import numpy as np
import pytest

from subsea.geometry.solids import from_pillar, from_rock
from subsea.lab.soak import depth_in_rock, faults_in, starving, stuck, visited_now, widen
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step


@pytest.fixture(scope="module")
def bay():
    world = create_world(load_scenario("peaceful")[0], fish=20)
    step(world, NEUTRAL)
    return world, snapshot.take(world)


@pytest.fixture
def world(bay):
    world, before = bay
    snapshot.restore(world, before)
    return world


def middle_of_a_rock(world):
    rocks = world.state.sea.rocks
    return rocks[np.argmax(rocks[:, 2] * (rocks[:, 3:6].min(axis=1) > 40.0)), :3]


def test_an_intact_world_has_no_faults(world):
    for _ in range(60):
        step(world, NEUTRAL)
        assert faults_in(world) == []


@pytest.mark.parametrize(
    ("part", "name", "place", "value", "told"),
    [
        ("fishes", "position", 4, (0.0, 0.0, 40.0), "fish 4 is out of the sea, at 0, 0, 40"),
        ("fishes", "position", 4, (0.0, 0.0, -9000.0), "fish 4 is out of the sea"),
        ("fishes", "position", 4, (1e5, 0.0, -100.0), "fish 4 is out of the sea"),
        ("fishes", "velocity", 4, (np.nan, 0.0, 0.0), "fishes.velocity contains NaN"),
        ("fishes", "row_a", 4, -3, "fishes.row_a[4] is -3, which no tick writes"),
        ("fishes", "previous_position", 4, (0.0, 0.0, -9.0), "fish 4 moves at "),
        ("fishes", "orientation", 4, (0.5, 0.0, 0.0, 0.0), "fishes.orientation[4] is a quaternion"),
        ("minds", "mental", (4, 0), 1.5, "minds.mental[4, 0] is 1.5, expected a share"),
        ("fishes", "gape", 4, -0.5, "fishes.gape[4] is -0.5, expected a share"),
        ("sea", "plankton", 7, (0.0, 0.0, 1.0), "a speck of plankton is out of the sea, at 0, 0,"),
        ("sea", "plankton", 7, (0.0, np.nan, 1.0), "sea.plankton contains NaN"),
        ("seaweed", "node", (3, 2), np.nan, "seaweed.node contains NaN"),
        ("submarine", "position", slice(3), (0.0, 0.0, 3.0), "the submarine is out of the sea"),
        ("submarine", "velocity", 0, 1000.0, "the submarine moves at "),
        ("submarine", "angles", 1, 1.3, "the submarine's pitch is 74 degrees"),
    ],
)
def test_broken_invariants_are_found(world, part, name, place, value, told):
    getattr(getattr(world.state, part), name)[place] = value
    if (part, name) == ("fishes", "position"):  # avoids a fault by too high speed
        world.state.fishes.previous_position[place] = value
    found = faults_in(world)
    assert len(found) == 1 and told in found[0], found


def test_bodies_inside_rock_are_found(world):
    there = middle_of_a_rock(world)
    world.state.submarine.position[:] = there
    world.state.fishes.position[3] = world.state.fishes.previous_position[3] = there
    told = " ".join(faults_in(world))
    assert "fish 3 is" in told
    assert "the submarine is" in told
    assert told.count("cm inside rock") == 2


def test_the_depth_in_rock_is_that_of_the_solids(world):
    sea = world.state.sea
    sea = sea._replace(pillars=np.array([[60.0, -40.0, 50.0, -200.0]]))
    around = np.random.default_rng(1).normal(0.0, 60.0, (400, 3))
    corner = np.array([60.0, -40.0, -210.0])
    places = np.concatenate([corner + around, middle_of_a_rock(world) + around])
    gap = np.array([
        min(
            [from_pillar(row, tuple(p))[1] for row in sea.pillars]
            + [from_rock(row, tuple(p))[1] for row in sea.rocks]
        )
        for p in places
    ])  # fmt: skip
    deep = depth_in_rock(places, sea)
    np.testing.assert_allclose(deep, np.maximum(-gap, 0.0), atol=1e-9)
    assert 100 < (deep > 0.0).sum() < 700
    assert depth_in_rock(np.array([[60.0, -10.0, -280.0]]), sea) == pytest.approx(20.0)


def test_dead_and_caught_fishes_are_not_checked(world):
    world.state.fishes.position[[3, 5]] = 0.0, 0.0, 40.0
    world.state.fishes.alive[3] = False
    world.state.sea.catch[:] = 4, 5
    assert faults_in(world) == []


def test_a_fish_that_does_not_move_is_stuck(world):
    boxes = visited_now(world)
    held = world.state.fishes.position[6].copy()
    for _ in range(150):
        step(world, NEUTRAL)
        world.state.fishes.position[6] = held
        widen(boxes, world)
    assert stuck(boxes, world) == [6]
    world.state.fishes.alive[6] = False
    assert stuck(boxes, world) == []


def test_the_starving_are_counted(world):
    world.state.minds.mental[:, 0] = 0.4
    world.state.minds.mental[2:5, 0] = 1.0
    world.state.fishes.alive[3] = False
    assert starving(world) == 2
