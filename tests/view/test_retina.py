"""Position and field of view of a fish's eyes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from subsea.fish.species import load_species, species_names
from subsea.fish.surface import LEFT, RIGHT, rest_control_points
from subsea.frame.packet import PackOptions, pack
from subsea.geometry.rotation import matrix
from subsea.motor.pose import control_points_world
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.retina import (
    Gaze,
    eye_weights,
    eyes_pose,
    fish_eyes,
    gaze_axes,
    retina_rig,
    retinal_views,
)
from subsea.world.build import create_world
from subsea.world.step import step

SIZE = (64, 48)


@pytest.fixture(scope="module")
def world():
    world = create_world(load_scenario("peaceful")[0], fish=60)
    for _ in range(20):
        step(world, NEUTRAL)
    return world


@pytest.mark.parametrize("name", species_names())
def test_eyes_lie_on_the_skin_where_the_species_has_them(name):
    plan = load_species(name).surface
    weights = eye_weights(plan)
    assert weights.sum() == pytest.approx(1.0)
    rest = rest_control_points(plan, 1.0, 0.0)
    left, right = weights @ rest[LEFT], weights @ rest[RIGHT]
    np.testing.assert_allclose(left, right * (1, 1, -1), atol=1e-9)
    assert -right[0] == pytest.approx(plan.eye.at, abs=0.006)
    height = right[2] if plan.wing else right[1]
    assert height == pytest.approx(plan.eye.height, abs=0.006)
    assert right[2] > 0.005


def test_between_two_ticks_the_eyes_travel_with_the_body(world):
    fishes = world.state.fishes
    for fish in range(0, 60, 7):
        by = fish_eyes(world, fish)
        points = control_points_world(fishes, world.library, fish)
        middle = by.weights @ (points[LEFT] + points[RIGHT]) / 2
        looking = eyes_pose(world, by, 1.0)
        np.testing.assert_allclose(looking.eye, middle, atol=1e-3)
        axes = matrix(fishes.orientation[fish].astype(float))
        np.testing.assert_allclose(looking.forward, axes[:, 0], atol=1e-6)
        np.testing.assert_allclose(looking.up, axes[:, 1], atol=1e-6)
        before, between = eyes_pose(world, by, 0.0), eyes_pose(world, by, 0.5)
        way = np.linalg.norm(looking.eye - before.eye)
        assert np.linalg.norm(between.eye - (before.eye + looking.eye) / 2) < 0.2 * way + 0.1


def test_each_eye_is_on_its_side_and_misses_its_own_body(world):
    by = fish_eyes(world, 5)
    rig = retina_rig(SIZE, by.half_cm)
    left, right = retinal_views(world, by, rig, 1.0)
    assert left.without == right.without == 5
    axes = matrix(world.state.fishes.orientation[5].astype(float))
    np.testing.assert_allclose(right.eye - left.eye, 2 * by.half_cm * axes[:, 2], atol=1e-5)
    points = control_points_world(world.state.fishes, world.library, 5)
    for view, part in ((left, LEFT), (right, RIGHT)):
        # Where the skin bends with the beat, eyes are slightly off it.
        assert np.linalg.norm(by.weights @ points[part] - view.eye) < 0.25 * by.half_cm + 0.05


@pytest.mark.nightly
def test_eyes_of_a_simulated_fish_lie_on_the_body_that_is_drawn():
    # Beside stone some would be played back.
    bare = dict.fromkeys(("rock", "outcrop", "ridge", "arch", "reef", "tour"), ())
    scenario = replace(load_scenario("peaceful")[0], **bare)
    # A seed in which none rows or hovers, which would be played back too.
    world = create_world(scenario, seed=3, fish=12, live=12, live_reach_cm=np.inf)
    for _ in range(600):
        step(world, NEUTRAL)
        if world.state.fishes.live.all():
            break
    assert world.state.fishes.live.all()
    by = [fish_eyes(world, fish) for fish in range(12)]
    # Unskinned so far: their rows of control points are unchanged.
    eyes = [eyes_pose(world, one, 1.0).eye for one in by]
    pack(
        world,
        retinal_views(world, by[0], retina_rig(SIZE, 1.0), 1.0),
        1.0,
        PackOptions(culling=False),
    )
    for one, eye in zip(by, eyes, strict=True):
        points = control_points_world(world.state.fishes, world.library, one.fish)
        np.testing.assert_allclose(eye, one.weights @ (points[LEFT] + points[RIGHT]) / 2, atol=1e-3)


def test_the_field_is_as_wide_as_asked():
    for field in (60.0, 90.0, 130.0):
        projection = retina_rig(SIZE, 1.0, field_deg=field).eyes[0].projection
        assert 2 * np.degrees(np.arctan(1 / projection[0, 0])) == pytest.approx(field, abs=1e-3)
        # Pixels are square.
        assert projection[1, 1] / projection[0, 0] == pytest.approx(SIZE[0] / SIZE[1], rel=1e-5)


@given(st.floats(-180, 180), st.floats(-90, 90))
def test_a_gaze_turns_right_and_up_and_stays_a_rotation(pan, tilt):
    right, up, ahead = gaze_axes(Gaze(pan, tilt))
    np.testing.assert_allclose(
        np.stack([right, up, ahead]) @ np.stack([right, up, ahead]).T, np.eye(3), atol=1e-12
    )
    # In these axes ahead is up × right, as in the observer's.
    np.testing.assert_allclose(np.cross(right, up), ahead, atol=1e-12)
    assert ahead[1] == pytest.approx(np.sin(np.radians(tilt)))
    assert right[1] == 0.0  # the horizon stays level
    assert up[1] >= -1e-12


def test_ahead_is_ahead_right_is_right_and_up_is_up():
    np.testing.assert_allclose(gaze_axes(Gaze())[2], (0, 0, 1))
    np.testing.assert_allclose(gaze_axes(Gaze(90.0, 0.0))[2], (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(gaze_axes(Gaze(0.0, 90.0))[2], (0, 1, 0), atol=1e-12)


@given(st.floats(10.0, 300.0), st.floats(-0.4, 0.4), st.floats(-0.3, 0.3))
def test_disparity_is_that_of_the_baseline(ahead, aside, above):
    """A point `z` ahead is f·b/z pixels further right for the left eye, in the same row."""
    half = 1.3
    rig = retina_rig(SIZE, half)
    point = ahead * np.array([aside, above, 1.0])
    columns, rows = [], []
    for eye in rig.eyes:
        x, y, z = eye.axes @ (point - eye.offset)
        columns.append((eye.projection[0, 0] * x / z + 1) * SIZE[0] / 2)
        rows.append((eye.projection[1, 1] * y / z + 1) * SIZE[1] / 2)
    focal = rig.eyes[0].projection[0, 0] * SIZE[0] / 2
    assert columns[0] - columns[1] == pytest.approx(focal * 2 * half / ahead, rel=1e-5)
    assert rows[0] == pytest.approx(rows[1], abs=1e-6)
