"""Habits of light and temperature (Tu §7.3)."""

import numpy as np
import pytest

from subsea.behavior import leaving, schooling, wandering
from subsea.perception.comfort import sense_comfort
from subsea.perception.senses import feel_water
from subsea.scenario.load import load_scenario
from subsea.state import BRIGHTNESS, COLD, DARKNESS, PREDATOR, WARMTH
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S


def test_discontent_fishes_leave_in_the_right_direction(tank):
    t = tank(7)
    t.minds.light[:], t.minds.temperature[:] = 0.2, 26.0
    t.minds.likes[1, BRIGHTNESS] = True
    t.minds.likes[2, DARKNESS] = True  # content
    t.minds.likes[3, [BRIGHTNESS, DARKNESS]] = True  # indifferent
    t.minds.likes[4, COLD] = True
    t.minds.likes[5, WARMTH] = True  # content
    t.minds.likes[6, BRIGHTNESS] = True
    t.minds.kind[6] = PREDATOR  # cruises perpetually
    wants = t.desire(leaving.desire) > 0
    np.testing.assert_array_equal(wants, [False, True, False, False, True, False, False])
    t.run(leaving.act, 1, 4)
    assert t.minds.urge[1, 2] > 0 > t.minds.urge[4, 2]


def sensed(t):
    """Let all fishes feel the water where they are."""
    everyone = np.arange(len(t.fishes.length))
    feel_water(everyone, t.fishes.position, t.sea, t.minds.light, t.minds.temperature)
    sense_comfort(everyone, t.minds, t.sea.climate, t.nature)
    return t.desire(leaving.desire) > 0


@pytest.mark.parametrize("fade", [250.0, 700.0, 5000.0])
@pytest.mark.parametrize("surface_c", [27.0, 15.0])
def test_thresholds_are_shares_of_the_range_of_the_sea(tank, fade, surface_c):
    """In a clear sea, and in one that is colder above, there is dusk and mild water as well."""
    t = tank(400)
    t.sea.climate[:] = surface_c, 21.0, 600.0, fade
    t.fishes.position[:, 2] = -np.linspace(5.0, 595.0, 400)
    for habit in (BRIGHTNESS, DARKNESS, WARMTH, COLD):
        t.minds.likes[:] = False
        t.minds.likes[:, habit] = True
        leaves, (top, bottom) = sensed(t), t.minds.comfort[0]
        depth = -t.fishes.position[:, 2]
        np.testing.assert_array_equal(leaves[depth < top - 15.0], True)
        np.testing.assert_array_equal(leaves[depth > bottom + 15.0], True)
        assert not leaves[(depth > top) & (depth < bottom)].any()
        assert 0.1 < leaves.mean() < 0.9


def test_a_shoal_may_have_thresholds_of_its_own(tank):
    t = tank(2, mild=0.5)
    t.minds.likes[:, COLD] = True
    t.minds.mild[1] = 0.2
    sensed(t)
    assert t.minds.comfort[:, 0].tolist() == [300.0, 480.0]


def test_habits_that_contradict_each_other_meet_half_way(tank):
    t = tank(200)
    t.fishes.position[:, 2] = -np.linspace(5.0, 595.0, 200)
    t.minds.likes[:, [BRIGHTNESS, COLD]] = True
    leaves = sensed(t)
    top, bottom = t.minds.comfort[0]
    assert top == bottom
    content = -t.fishes.position[~leaves, 2]
    assert 0 < len(content) < 60
    assert abs(np.median(content) - top) < 40.0


def test_waypoints_lie_where_a_fish_is_content(tank):
    t = tank(200)
    t.minds.likes[:100, DARKNESS] = True
    t.minds.likes[100:, WARMTH] = True
    t.fishes.position[:, 2] = np.repeat((-400.0, -200.0), 100)
    t.fishes.position[:, 0] = 0.0
    sensed(t)
    t.minds.patience[:] = 0.0
    t.run(wandering.act)
    depth = -t.minds.waypoint[:, 2]
    assert ((depth >= t.minds.comfort[:, 0] - 1.0) & (depth <= t.minds.comfort[:, 1] + 1.0)).all()
    assert depth.std() > 20.0


def test_dislike_ranks_above_calm_schooling_and_a_school_leaves_together(tank):
    t = tank(3)
    t.minds.schools[:], t.minds.leads[0], t.minds.leader[1:] = True, True, 0
    t.minds.school_size[:], t.minds.leader_seen[:] = 3.0, 0.0
    t.minds.neighbour[:, :2] = (1, 2), (0, 2), (0, 1)
    t.minds.likes[:, BRIGHTNESS] = True
    t.fishes.position[:, 2] = -580.0
    sensed(t)
    assert (t.desire(leaving.desire) > t.desire(schooling.desire)).all()
    assert (t.desire(schooling.desire) > 0.0).all()
    t.minds.waypoint[:] = (0.0, 600.0, -100.0), (600.0, 0.0, -100.0), (0.0, -600.0, -100.0)
    t.minds.patience[:], t.minds.held[:] = 50.0, 1.0
    t.run(leaving.act)
    assert (t.minds.urge[:, 2] > 0.0).all()
    assert (t.minds.urge[:, 0] > 0.8 * np.linalg.norm(t.minds.urge[:, :2], axis=1)).all()


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(3, 13))
def test_fishes_of_the_twilight_slope_sort_themselves_and_stay(seed):
    world = create_world(
        load_scenario("twilight", ["water.plankton=0", "seaweed=[]"]).scenario, seed=seed
    )
    fishes, minds = world.state.fishes, world.state.minds
    content = []
    for tick in range(round(75.0 / TICK_S)):
        step(world, NEUTRAL)
        if tick % 30 == 0:
            depth, near = -fishes.position[:, 2], 20.0
            top, bottom = minds.comfort.T
            content.append((depth > top - near) & (depth < bottom + near))
    assert content[1].mean() < 0.6
    last = np.array(content[-12:])  # 12 s
    assert last.mean() > 0.88
    # Those that like light are above those that like darkness.
    light, dark = (minds.likes[:, habit] for habit in (BRIGHTNESS, DARKNESS))
    assert -fishes.position[light, 2].mean() < -fishes.position[dark, 2].mean() - 120.0
