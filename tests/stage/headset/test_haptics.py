"""Pulses in the hands of a diver."""

import numpy as np
import pytest

from subsea.dive.start import start_world
from subsea.stage.headset.display import NEAR_CM, STRONGEST_PASS, hand_pulses
from subsea.state import PREDATOR
from subsea.view.display_rigs import cockpit


@pytest.fixture
def sea(quiet):
    world = start_world(quiet, 1, None, lambda line: None)
    world.state.minds.kind[:] = 0
    return world


def pulses(world):
    return hand_pulses(world, cockpit(world.state.submarine, 1.0))


def test_nothing_is_felt_in_free_water(sea):
    np.testing.assert_array_equal(pulses(sea), 0.0)


def test_the_hull_that_a_stone_pushes_back_knocks_in_both_hands(sea):
    submarine = sea.state.submarine
    submarine.previous_position = submarine.position + np.array([2.0, 0.0, 0.0])
    np.testing.assert_allclose(pulses(sea), 0.5, atol=0.05)
    submarine.previous_position = submarine.position + np.array([50.0, 0.0, 0.0])
    np.testing.assert_array_equal(pulses(sea), 1.0)


@pytest.mark.parametrize(("side", "hand"), [(-1.0, 0), (1.0, 1)])
def test_a_shark_is_felt_on_its_side_and_the_more_the_nearer(sea, side, hand):
    pose, fishes = cockpit(sea.state.submarine, 1.0), sea.state.fishes
    right = np.cross(pose.forward, pose.up)
    fishes.length[0], sea.state.minds.kind[0] = 150.0, PREDATOR
    felt = []
    for away in (0.9 * NEAR_CM, 0.2 * NEAR_CM):
        fishes.position[0] = pose.eye + side * away * right
        felt.append(pulses(sea))
    assert felt[0][1 - hand] == felt[1][1 - hand] == 0.0
    assert 0.0 < felt[0][hand] < felt[1][hand] < STRONGEST_PASS
    fishes.length[0] = 30.0  # a small hunter
    np.testing.assert_array_equal(pulses(sea), 0.0)
