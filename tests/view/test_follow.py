"""The follow camera: the fish stays in sight, motion is smooth, no solid is entered."""

import numpy as np
import pytest

from subsea.geometry.rotation import rotate
from subsea.geometry.solids import height_at
from subsea.habitat.contact import clearances
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.follow import BACK_BL, BACK_CM, ROOM_CM, follow_fish
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

NEAR_CM = 8.0  # clearance of the near plane's corners


@pytest.fixture(scope="module")
def world():
    return create_world(load_scenario("peaceful")[0], fish=60)


def gap(sea, eye):
    """Distance of an eye from everything that it must not enter."""
    stone = clearances(sea.pillars, sea.rocks, eye[None])[0]
    return min(stone, eye[2] - height_at(sea.floor, sea.half_width, eye[0], eye[1]), -eye[2])


def test_it_sees_its_fish_from_behind_and_above_more_calmly_than_that_swims(world):
    fishes = world.state.fishes
    fish = [0, 12, 30, 57]  # that keep their way
    cameras = dict.fromkeys(fish)
    looks, heads = [], []
    for _ in range(90):
        step(world, NEUTRAL)
        for one in fish:
            cameras[one], pose = follow_fish(world, one, 1.0, cameras[one])
            away = fishes.position[one] - pose.eye
            far = np.linalg.norm(away)
            assert far < 1.4 * (BACK_CM + BACK_BL * fishes.length[one])
            assert away @ pose.forward / far > np.cos(np.radians(25.0))  # well in sight
            assert pose.up[2] > 0.5 and pose.forward @ pose.up == pytest.approx(0.0, abs=1e-9)
            looks.append(pose.forward)
            heads.append(rotate(fishes.orientation[one], (1.0, 0.0, 0.0)))
    looks, heads = (np.array(ways).reshape(90, len(fish), 3) for ways in (looks, heads))
    shaken = [np.linalg.norm(np.diff(ways, 2, axis=0), axis=2).mean() for ways in (looks, heads)]
    assert shaken[0] < 0.2 * shaken[1]
    assert np.sum(looks[45:, :, :2] * heads[45:, :, :2], axis=2).mean() > 0.7  # it follows
    assert cameras[0].share == 1.0  # nothing is in its way here


def test_it_enters_neither_stone_nor_sand_nor_air_wherever_its_fish_is(world):
    fishes, sea = world.state.fishes, world.state.sea
    rng = np.random.default_rng(2)
    places = [rock[:3] + rock[3:6] * way for rock in sea.rocks for way in rng.normal(0, 1, (8, 3))]
    places += [(*rng.uniform(-800, 800, 2), z) for z in rng.uniform(-600, -2, 100)]
    fish, tried, near = 5, 0, 0
    for place in np.array(places):
        if gap(sea, place) < 3.0:  # no fish is there
            continue
        tried += 1
        turn = rng.normal(0, 1, 4)
        fishes.position[fish] = fishes.previous_position[fish] = place
        fishes.orientation[fish] = fishes.previous_orientation[fish] = turn / np.linalg.norm(turn)
        camera, pose = follow_fish(world, fish, 1.0, None)
        assert gap(sea, pose.eye) > NEAR_CM
        assert np.isfinite(pose.up).all()
        # Nothing is between it and its fish.
        between = place + np.linspace(0.0, 1.0, 30)[:, None] * (pose.eye - place)
        if camera.share > 0.0:
            assert min(gap(sea, one) for one in between) > -1.0
        near += camera.share < 1.0
    assert tried > 80
    assert near > 8


def test_it_looks_along_a_fish_among_growths_not_down_on_it(world):
    fishes, sea = world.state.fishes, world.state.sea
    rng, seen = np.random.default_rng(4), 0
    for x, y in rng.uniform(-800.0, 800.0, (600, 2)):
        ground = height_at(sea.heights, sea.half_width, x, y)
        place = np.array([x, y, ground + 15.0])
        among = 60.0 < height_at(sea.floor, sea.half_width, x, y) - place[2] < 150.0
        if not among or clearances(sea.pillars, sea.rocks, place[None])[0] < 70.0:
            continue
        seen += 1
        fishes.position[5] = fishes.previous_position[5] = place
        fishes.orientation[5] = fishes.previous_orientation[5] = 1.0, 0.0, 0.0, 0.0
        _, pose = follow_fish(world, 5, 1.0, None)
        assert pose.forward[2] > -0.7
        assert pose.eye[2] > height_at(sea.heights, sea.half_width, *pose.eye[:2]) + NEAR_CM
    assert seen > 3


def test_it_comes_nearer_at_once_and_goes_back_slowly(world):
    fishes, sea = world.state.fishes, world.state.sea
    fish = 5
    fishes.position[fish] = fishes.previous_position[fish] = 0.0, 0.0, -250.0
    fishes.orientation[fish] = fishes.previous_orientation[fish] = np.sqrt([0.5, 0.5, 0.0, 0.0])
    camera, pose = follow_fish(world, fish, 1.0, None)
    assert camera.share == 1.0
    aside = dict(zip(("pillars", "rocks"), (sea.pillars, sea.rocks), strict=True))
    middle = 0.5 * (pose.eye + (0.0, 0.0, -250.0))
    wall = np.array([[*middle, 3.0, 60.0, 60.0, 0.0]])
    blocked = world.state.sea
    world.state.sea = blocked._replace(rocks=wall, pillars=np.zeros((0, 4)))
    camera, nearer = follow_fish(world, fish, 1.0, camera)
    assert np.linalg.norm(nearer.eye - fishes.position[fish]) < np.linalg.norm(
        middle - fishes.position[fish]
    )
    world.state.sea = blocked._replace(**aside)
    shares = []
    for _ in range(60):
        world.state.tick += 1
        camera, _ = follow_fish(world, fish, 1.0, camera)
        shares.append(camera.share)
    assert shares[0] < 0.6
    assert shares[-1] == 1.0
    assert np.diff(shares).max() < 0.05
    assert ROOM_CM > NEAR_CM


def test_it_never_sits_in_another_fish_of_a_dense_school_nor_jumps(world):
    fishes, rng = world.state.fishes, np.random.default_rng(6)
    fish, mates = 0, np.arange(1, 50)
    length = float(fishes.length[fish])
    middle = np.array([-250.0, 60.0, -250.0])
    drift = rng.uniform(-1.0, 1.0, (len(mates), 3)) * (30.0, 3.0, 3.0)  # cm/s
    fishes.orientation[: len(mates) + 1] = fishes.previous_orientation[: len(mates) + 1] = (
        1.0, 0.0, 0.0, 0.0,
    )  # fmt: skip
    fishes.position[fish] = fishes.previous_position[fish] = middle
    _, pose = follow_fish(world, fish, 1.0, None)
    start = pose.eye - middle + rng.uniform(-1.0, 1.0, (len(mates), 3)) * (4.0, 0.8, 0.8) * length
    camera, before, pushed, least = None, None, 0, np.inf
    for k in range(240):
        world.state.tick += 1
        there = middle + start + k * TICK_S * drift
        fishes.position[mates] = fishes.previous_position[mates] = there
        camera, pose = follow_fish(world, fish, 1.0, camera)
        away = pose.eye - there
        along = np.clip(away[:, 0], -0.45 * fishes.length[mates], 0.45 * fishes.length[mates])
        away[:, 0] -= along
        least = min(least, float((np.linalg.norm(away, axis=1) / fishes.length[mates]).min()))
        pushed += np.linalg.norm(camera.dodge) > 1.0
        if before is not None:
            assert np.linalg.norm(pose.eye - before) < 9.0  # no cut
        before = pose.eye
    assert pushed > 8  # fishes were in its place
    assert least > 0.25  # half the height of a body and the near plane
