"""Wandering from waypoint to waypoint."""

import numpy as np

from subsea.behavior import wandering
from subsea.behavior.steering import heed


def test_a_loner_in_open_water_swims_to_its_waypoint(tank):
    t = tank()
    for tick in range(60):
        now = t.at(tick)
        now.run(wandering.act)
        heed(now.fishes, now.minds, now.clock)
    toward = t.minds.waypoint[0] - t.fishes.position[0]
    assert t.fishes.goal_direction[0] @ toward / np.linalg.norm(toward) > 0.99
    assert 10 < np.hypot(*t.minds.waypoint[0, :2]) < t.sea.radius
    assert t.minds.waypoint[0, 2] > -600 + wandering.FLOOR_CM - 1


def test_patience_ends(tank):
    t = tank()
    t.minds.waypoint[:] = 500.0, 0.0, -300.0
    t.minds.patience[:] = 0.5
    for tick in range(10):
        t.at(tick).run(wandering.act)
        np.testing.assert_allclose(t.minds.waypoint[0], [500.0, 0.0, -300.0])
    for tick in range(10, 30):
        t.at(tick).run(wandering.act)
    assert np.linalg.norm(t.minds.waypoint[0] - [500.0, 0.0, -300.0]) > 1
    low, high = wandering.PATIENCE_S
    assert low - 1 <= t.minds.patience[0] <= high


def test_a_recommendation_against_monotony_is_taken_up(tank):
    t = tank(2)
    t.fishes.recommended[:] = -1, 0
    t.run(wandering.act)
    np.testing.assert_allclose(t.fishes.goal_speed, [0.5, wandering.CRUISE[0]])


def test_a_leader_keeps_its_school_moving_but_waits_for_it(tank):
    t = tank(2)
    t.minds.leads[:] = True
    t.minds.neighbour[0] = 1
    t.fishes.recommended[:] = 0
    t.run(wandering.act)
    np.testing.assert_allclose(t.fishes.goal_speed, [wandering.LEADING, wandering.WAITING])


def test_waypoints_lie_in_free_water(tank):
    """Solids fill a third of the sea."""
    pillars = [(x, y, 110.0, 0.0) for x in (-500, 0, 500) for y in (-500, 0, 500)]
    t = tank(200, pillars=pillars)
    t.minds.patience[:] = 0.0
    t.run(wandering.act)
    places = t.minds.waypoint[:, None, :2] - np.array(pillars)[None, :, :2]
    gap = np.linalg.norm(places, axis=2).min(axis=1) - 110.0
    assert (gap > wandering.FREE_CM - 1).mean() > 0.95
