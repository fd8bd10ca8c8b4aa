"""Which species and behaviors can be recognised in a picture."""

import numpy as np
import pytest

from subsea.dive.sightings import BEHAVIORS, CLEAR, LEAST_SHARE, sightings
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import with_total
from subsea.state import CURIOUS, ESCAPE, PREDATOR, RUSHING, SCHOOL, SPAWNING, WANDER
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import display_rig
from subsea.view.front_screen import front_screen
from subsea.view.rig import pose_from_angles, views
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

EYE = np.array([0.0, 0.0, -200.0])  # ahead is +y


@pytest.fixture(scope="module")
def made():
    world = create_world(with_total(load_scenario("mating")[0], 12))
    step(world, NEUTRAL)
    return world


@pytest.fixture
def sea(made):
    """A sea whose fishes are all behind the eye, and its view."""
    fishes, minds = made.state.fishes, made.state.minds
    fishes.position[:] = fishes.previous_position[:] = EYE - (0.0, 300.0, 0.0)
    minds.intention[:], minds.courtship[:], minds.schools[:] = WANDER, 0, False
    rig = display_rig("mono", (640, 360))
    return made, front_screen(rig, views(rig, pose_from_angles(EYE, np.pi / 2, 0.0)))


def put(world, fish, ahead, aside=0.0):
    fishes = world.state.fishes
    fishes.position[fish] = fishes.previous_position[fish] = EYE + (aside, ahead, 0.0)


def subjects(sea):
    return {one.subject: one.fish for one in sightings(*sea, 1.0)}


def test_nobody_is_seen_behind_the_eye(sea):
    assert subjects(sea) == {}


def test_a_species_is_seen_near_and_inside_the_picture(sea):
    world, front = sea
    put(world, 0, 120.0)
    name = world.species[world.state.fishes.species[0]].name
    assert subjects(sea) == {name: 0}
    (one,) = sightings(world, front, 1.0)
    assert (one.x, one.y) == pytest.approx((0.5, 0.5), abs=0.02)
    put(world, 0, 120.0, aside=500.0)
    assert subjects(sea) == {}


def test_one_that_is_far_or_small_is_not(sea):
    world, front = sea
    focal = float(front.view.projection[1, 1]) / 2.0
    reach = focal * float(world.state.fishes.length[0]) / LEAST_SHARE
    put(world, 0, 1.05 * reach)
    assert subjects(sea) == {}
    put(world, 0, 0.95 * reach)
    seen = bool(subjects(sea))
    assert seen == (0.95 * reach < CLEAR * world.scenario.water.visibility_cm)


def test_the_largest_in_the_picture_stands_for_its_species(sea):
    world, _ = sea
    same = np.flatnonzero(world.state.fishes.species == world.state.fishes.species[0])[:2]
    put(world, same[0], 150.0, 30.0)
    put(world, same[1], 80.0, -10.0)
    assert list(subjects(sea).values()) == [same[1]]


def test_behaviors_are_those_of_minds(sea):
    world, _ = sea
    minds = world.state.minds
    put(world, 0, 120.0)
    minds.courtship[0] = SPAWNING
    assert "spawning" in subjects(sea) and "courtship" not in subjects(sea)
    minds.courtship[0] = 0
    minds.intention[0] = CURIOUS
    world.state.submarine.position[:] = EYE
    assert subjects(sea)["visit"] == 0


def test_a_sea_without_sites_has_no_bathers(sea, monkeypatch):
    world, _ = sea
    bare = world.state.sea._replace(site_place=world.state.sea.site_place[:0])
    monkeypatch.setattr(world.state, "sea", bare)
    world.state.minds.cover[:] = -1
    put(world, 0, 120.0)
    assert len(subjects(sea)) == 1


def test_a_hunt_and_a_catch_are_of_predators(sea):
    world, _ = sea
    minds = world.state.minds
    put(world, 0, 120.0)
    kind, minds.kind[0], minds.hunt[0] = minds.kind[0], PREDATOR, RUSHING
    minds.last_meal[0] = world.state.tick * TICK_S
    assert {"hunt", "catch"} <= set(subjects(sea))
    minds.last_meal[0] -= 5.0
    assert "catch" not in subjects(sea)
    minds.kind[0], minds.hunt[0] = kind, 0


def test_a_mill_circles_and_a_school_does_not(sea, monkeypatch):
    world, _ = sea
    fishes, minds = world.state.fishes, world.state.minds
    many = np.arange(8)
    one_species = fishes._replace(species=np.zeros_like(fishes.species))
    monkeypatch.setattr(world.state, "fishes", one_species)
    turns = np.linspace(0.0, 2.0 * np.pi, len(many), endpoint=False)
    for fish, turn in zip(many, turns, strict=True):
        put(world, fish, 150.0 + 20.0 * np.cos(turn), 20.0 * np.sin(turn))
        fishes.velocity[fish] = 15.0 * np.cos(turn), -15.0 * np.sin(turn), 0.0
    minds.schools[many], minds.intention[many] = True, SCHOOL
    assert {"school", "mill"} <= set(subjects(sea))
    fishes.velocity[many] = 15.0, 0.0, 0.0
    assert "school" in subjects(sea) and "mill" not in subjects(sea)
    minds.intention[many] = ESCAPE
    assert "flight" in subjects(sea) and "school" not in subjects(sea)


def test_every_behavior_has_a_title_and_a_hint():
    for seen in BEHAVIORS.values():
        assert seen.title and seen.hint.endswith(".")
