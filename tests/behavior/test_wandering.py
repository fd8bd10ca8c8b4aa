"""Wandering from waypoint to waypoint."""

import numpy as np

from subsea.behavior import wandering
from subsea.behavior.steering import ease_goals
from subsea.geometry.rotation import from_matrix
from subsea.world.world import TICK_S
from tests.support.scenes import everyone


def test_a_loner_in_open_water_swims_to_its_waypoint(tank):
    t = tank()
    for tick in range(60):
        now = t.at(tick)
        now.run(wandering.act)
        ease_goals(everyone(now.fishes), now.fishes, now.minds, now.clock)
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
    way = np.linalg.norm(t.minds.waypoint[0] - t.fishes.position[0])
    beyond = t.minds.patience[0] - way / (wandering.SLOWEST * t.fishes.fast[0])
    assert low - 1 <= beyond <= high


def test_a_recommendation_against_monotony_is_taken_up(tank):
    t = tank(2)
    t.fishes.recommended[:] = -1, 0
    t.run(wandering.act)
    np.testing.assert_allclose(t.fishes.goal_speed, [0.5, wandering.CRUISE[0]], atol=0.01)


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


def test_by_night_fishes_roam_nearer_to_the_ground(tank):
    heights = []
    for daylight in (1.0, 0.0):
        t = tank(400)
        t.sea.sky[1], t.minds.patience[:] = daylight, 0.0
        t.fishes.position[:, 2] = -450.0
        t.run(wandering.act)
        heights.append(t.minds.waypoint[:, 2].mean())
    assert heights[1] < heights[0] - 20.0


def test_a_leader_waits_for_followers_left_behind(tank):
    speeds = []
    for far in (50.0, 500.0):
        t = tank(3)
        t.minds.leads[0], t.minds.leader[1:], t.minds.leader_seen[:] = True, 0, 0.0
        t.minds.neighbour[0, 0] = 1
        t.fishes.position[2, 0] = far
        t.run(wandering.act, 0)
        speeds.append(t.fishes.goal_speed[0])
    np.testing.assert_allclose(speeds, [0.5, wandering.WAITING], atol=0.01)


def test_the_ways_of_leaders_have_room_for_a_school(tank):
    pillars = [(x, y, 40.0, 0.0) for x in (-400, 0, 400) for y in (-400, 0, 400) if x or y]
    share = []
    for leads in (False, True):
        t = tank(200, pillars=pillars)
        t.minds.patience[:], t.minds.leads[:] = 0.0, leads
        t.run(wandering.act)
        way = t.minds.waypoint[:, None, :2].astype(float)
        along = (way * np.array(pillars)[None, :, :2]).sum(axis=2) / (way**2).sum(axis=2)
        nearest = np.clip(along, 0.0, 1.0)[:, :, None] * way - np.array(pillars)[None, :, :2]
        gap = np.linalg.norm(nearest, axis=2).min(axis=1) - 40.0
        share.append((gap > wandering.BROAD_CM - 1.0).mean())
    assert share[0] < 0.6
    assert share[1] > 0.95


def test_a_near_solid_bars_only_a_way_that_leads_to_it(tank):
    sea = tank(
        1, pillars=[(0.0, 0.0, 40.0, 0.0)], rocks=[(0.0, 300.0, -200.0, 40.0, 40.0, 40.0, 0)]
    ).sea

    def is_broad(*way):
        return wandering.is_broad(sea, *(tuple(np.float32(place)) for place in way))

    for here in ((60.0, 0.0, -200.0), (60.0, 300.0, -200.0)):
        assert is_broad(here, (500.0, here[1], -200.0))
        assert not is_broad(here, (-500.0, here[1], -200.0))
    assert not is_broad((-500.0, 130.0, -200.0), (500.0, 130.0, -200.0))


def test_a_fish_with_a_home_wanders_near_it(tank):
    t = tank(300)
    t.minds.home[:], t.minds.home_range[:], t.minds.patience[:] = (200.0, 0.0, -560.0), 100.0, 0.0
    t.run(wandering.act)
    way = t.minds.waypoint - t.minds.home
    far = np.linalg.norm(way, axis=1)
    assert 50 < far.max() < 100
    assert t.minds.waypoint[:, 2].min() >= -600 + wandering.HOME_FLOOR_CM
    assert wandering.is_at_home(t.minds, 0, tuple(t.minds.waypoint[0].astype(float)))
    assert not wandering.is_at_home(t.minds, 0, (0.0, 0.0, -560.0))


def swims(t, ticks, speed=4.0):
    """Paths (ticks, n, 3) of fishes that follow their goals, `speed` cm a tick."""
    paths = []
    for tick in range(ticks):
        now = t.at(tick)
        now.run(wandering.act)
        ease_goals(everyone(now.fishes), now.fishes, now.minds, now.clock)
        x = now.fishes.goal_direction.astype(float)
        right = np.cross(x, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right, axis=1)[:, None]
        turns = np.stack([x, np.cross(right, x), right], axis=2)
        now.fishes.orientation[:] = [from_matrix(turn) for turn in turns]
        now.fishes.position[:] += np.float32(speed * x)
        paths.append(now.fishes.position.copy())
    return np.array(paths)


def test_a_fish_that_keeps_to_the_ground_follows_it_in_its_range_of_heights(tank):
    """The ground rises to the east by 1 in 10 and the fishes begin far above it."""
    t = tank(8)
    slope = np.linspace(-600.0, -400.0, t.sea.floor.shape[1], dtype=np.float32)
    ground = np.tile(slope, (len(slope), 1))
    t = t._replace(sea=t.sea._replace(floor=ground, heights=ground))
    t.minds.cruise_height[:] = 60.0, 120.0
    t.fishes.position[:, 2] = -200.0
    paths = swims(t, 900)
    places = np.linspace(-t.sea.half_width, t.sea.half_width, len(slope))
    height = (paths[..., 2] - np.interp(paths[..., 0], places, slope))[300:]
    assert np.percentile(height, 5) > 45.0
    assert np.percentile(height, 95) < 135.0
    # The ease of the goal, at 4 per s, follows a turn of at most 30 degrees.
    course = np.unwrap(np.arctan2(*np.diff(paths, axis=0)[..., 1::-1].transpose(2, 0, 1)), axis=0)
    most = np.degrees(np.abs(np.diff(course, axis=0))).max()
    assert most < 30.0 * 4.0 * TICK_S + 0.5


def test_the_waypoints_of_such_a_fish_lie_ahead_of_it(tank):
    t = tank(300)
    t.minds.cruise_height[:], t.minds.patience[:] = (60.0, 120.0), 0.0
    t.run(wandering.act)
    way = t.minds.waypoint - t.fishes.position
    assert (way[:, 0] / np.linalg.norm(way, axis=1) > wandering.AHEAD_COS - 0.1).all()
    height = t.minds.waypoint[:, 2] + 600.0
    assert 74.0 <= height.min() < 80.0
    assert 110.0 < height.max() <= 121.0


def test_a_fish_on_an_errand_leaves_the_ground(tank):
    t = tank()
    t.minds.cruise_height[:], t.minds.errand[:] = (60.0, 120.0), 0.5
    t.minds.waypoint[:] = 0.0, 300.0, -100.0
    t.run(wandering.act)
    assert t.minds.urge[0, 1] > 0.5
    assert t.minds.urge[0, 2] > 0.3


def test_long_fishes_keep_their_waypoints_off_the_wall(tank):
    far = []
    for length in (20.0, 200.0):
        t = tank(300)
        t.fishes.length[:], t.minds.patience[:] = length, 0.0
        t.run(wandering.act)
        far.append(np.hypot(*t.minds.waypoint[:, :2].T).max())
    assert far[0] > 0.75 * t.sea.radius
    assert far[1] <= t.sea.radius - wandering.BERTH_BL * 200.0 + 1.0
