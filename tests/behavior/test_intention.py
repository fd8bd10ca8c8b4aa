"""Wishes of fishes in an empty sea."""

import numpy as np
import pytest
from subsea.behavior.routines import FLOOR_CM, MARGIN_CM, STARTLE_CM, SURFACE_CM

from subsea.behavior.intention import decide
from subsea.state import AVOID, INTENTIONS, SCHOOL, WANDER, empty_fishes

RADIUS, WIDTH, TICK = 1000.0, 1600.0, 0.033
FLOOR = np.full((9, 9), -600.0, np.float32)
FAR_AWAY = np.array([0.0, 0.0, 1e6])


def _decide(fishes, submarine=FAR_AWAY, ticks=30, seed=1):
    for tick in range(ticks):
        decide(fishes, FLOOR, WIDTH, RADIUS, submarine, seed, tick, TICK)


def _fish(position, velocity=(15.0, 0.0, 0.0), n=1):
    fishes = empty_fishes(n)
    fishes.length[:] = 20.0
    fishes.position[:] = position
    fishes.velocity[:] = velocity
    fishes.waypoint[:] = position
    fishes.goal_direction[:] = np.array(velocity) / np.linalg.norm(velocity)
    fishes.goal_speed[:] = 0.5
    return fishes


def test_a_loner_in_open_water_wanders_toward_its_waypoint():
    fishes = _fish((0.0, 0.0, -300.0))
    _decide(fishes, ticks=60)
    assert INTENTIONS[fishes.intention[0]] == "wander"
    toward = fishes.waypoint[0] - fishes.position[0]
    assert fishes.goal_direction[0] @ toward / np.linalg.norm(toward) > 0.99
    assert np.hypot(*fishes.waypoint[0, :2]) < RADIUS


@pytest.mark.parametrize(
    ("place", "velocity", "inward"),
    [
        ((RADIUS - 0.3 * MARGIN_CM, 0, -300), (15, 0, 0), (-1, 0, 0)),
        ((0, RADIUS - 0.3 * MARGIN_CM, -300), (0, 15, 0), (0, -1, 0)),
        ((0, 0, -600 + 0.3 * FLOOR_CM), (15, 0, -5), (0, 0, 1)),
        ((0, 0, -0.3 * SURFACE_CM), (15, 0, 5), (0, 0, -1)),
    ],
)
def test_near_a_boundary_the_wish_points_inward(place, velocity, inward):
    fishes = _fish(place, velocity)
    # Bound outward: the boundary must win over the waypoint.
    fishes.waypoint[:] = np.array(place) - 300.0 * np.array(inward)
    fishes.patience[:] = 100.0
    _decide(fishes, ticks=60)
    assert fishes.goal_direction[0] @ np.array(inward) > 0.25
    assert fishes.intention[0] == AVOID


def test_followers_school_and_stragglers_catch_up():
    fishes = _fish((0.0, 0.0, -300.0), n=3)
    fishes.leader[1:] = 0
    fishes.position[1] = -40.0, 0.0, -300.0
    fishes.position[2] = -400.0, 50.0, -300.0
    _decide(fishes)
    assert fishes.intention[0] == WANDER
    assert (fishes.intention[1:] == SCHOOL).all()
    toward = fishes.position[0] - fishes.position[2]
    assert fishes.goal_direction[2] @ toward / np.linalg.norm(toward) > 0.9
    assert fishes.goal_speed[2] > fishes.goal_speed[1]


def test_companions_too_close_part():
    fishes = _fish((0.0, 0.0, -300.0), n=3)
    fishes.leader[1:] = 0
    fishes.position[1] = -60.0, 3.0, -300.0
    fishes.position[2] = -60.0, -3.0, -300.0
    fishes.neighbour[1, 0], fishes.neighbour[2, 0] = 2, 1
    _decide(fishes)
    assert fishes.goal_direction[1, 1] > fishes.goal_direction[2, 1]


def test_the_submarine_is_given_way():
    fishes = _fish((0.0, 0.0, -300.0))
    _decide(fishes, submarine=np.array([0.4 * STARTLE_CM, 0.0, -300.0]))
    assert fishes.goal_direction[0, 0] < 0
    assert fishes.intention[0] == AVOID


def test_wishes_change_smoothly_and_stay_unit_vectors():
    fishes = _fish((0.0, 0.0, -300.0))
    before = fishes.goal_direction.copy()
    for tick in range(600):
        decide(fishes, FLOOR, WIDTH, RADIUS, FAR_AWAY, 3, tick, TICK)
        now = fishes.goal_direction[0]
        assert abs(np.linalg.norm(now) - 1) < 1e-5
        assert now @ before[0] > np.cos(np.radians(25))
        before = fishes.goal_direction.copy()
