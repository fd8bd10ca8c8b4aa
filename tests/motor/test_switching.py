"""Switching between playback and simulation: smooth, within the budget, repeatable."""

from itertools import product

import msgspec
import numpy as np
import pytest

from subsea.fish.species import muscular_names
from subsea.motor.playback import ROW
from subsea.motor.pose import nodes_world
from subsea.motor.switching import KEEP, MAX_WAIT_TICKS, MIN_STAY_S, may_go_live, steady
from subsea.repertoire import BASIC_SEGMENTS
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import only

TICK = 0.033
LIMIT = 2.0  # times the largest change of velocity that playback itself makes
RANDOM_LIMIT = 1.5  # likewise, of the changes in a sample of turns
each_species = pytest.mark.parametrize("species", only(("emperor_angelfish",), muscular_names()))
CYCLIC = [name for name in BASIC_SEGMENTS if "swim" in name]


def _changes(path):
    """The largest change of any node's velocity at each frame, cm per tick²."""
    return np.linalg.norm(np.diff(path, 2, axis=0), axis=2).max(axis=1)


def _steps(path):
    """The largest step of any node at each frame, cm."""
    return np.linalg.norm(np.diff(path, axis=0), axis=2).max(axis=1)


@each_species
def test_going_live_jerks_no_node_at_any_phase(make_tank, species):
    for name, row in product(CYCLIC, range(0, 14, 3)):
        tank = make_tank(species).put(name, row)
        before = tank.step(16, obey=False)
        tank.to_live()
        path = np.concatenate([before, tank.step(30, obey=False)])
        assert tank.fishes.live[0], (name, row)
        assert _changes(path)[13:].max() <= LIMIT * _changes(before).max(), (name, row)
        assert _steps(path).max() <= 1.3 * _steps(before).max(), (name, row)


@pytest.mark.nightly
@each_species
def test_at_random_goals_no_one_notices_either_change(make_tank, species):
    for scale in (0.8, 1.0, 1.4):
        tank = make_tank(species, scale).put("swim_fast")
        rng = np.random.default_rng(3)
        # Below, fishes row or coast, which is played back.
        least = 0.95 if tank.library.has[0, ROW] else 0.45
        goals = rng.uniform((-np.pi, least, -0.6), (np.pi, 1.0, 0.6), (8, 3))
        usual = 0.0
        for goal in goals:
            tank.aim(*goal)
            usual = max(usual, _changes(tank.step(120)).max())
        for goal in goals:
            tank.aim(*goal)
            before = tank.step(rng.integers(5, 60))
            while tank.live.fish[0] >= 0 or not may_go_live(tank.fishes, tank.library, 0):
                before = np.concatenate([before, tank.step(1)])
                assert len(before) < 600, "never simulated"
            tank.to_live()
            live = tank.step(rng.integers(30, 200))
            assert tank.fishes.live[0]
            tank.leave()
            after = tank.step(MAX_WAIT_TICKS + 20)
            assert not tank.fishes.live[0]
            path = np.concatenate([before[-3:], live, after])
            assert _changes(path).max() <= RANDOM_LIMIT * usual, scale


def test_a_fish_that_leaves_keeps_its_speed(make_tank):
    tank = make_tank("fusilier").put("swim_medium")
    tank.to_live()
    tank.run(120)
    before = tank.step(14)
    tank.leave()
    tank.run(MAX_WAIT_TICKS)
    after = tank.step(14)
    speeds = [np.linalg.norm(path[-1] - path[0], axis=1).mean() for path in (before, after)]
    assert speeds[1] == pytest.approx(speeds[0], rel=0.12)


@pytest.mark.parametrize("fault", ["torn", "lost"])
def test_a_body_that_loses_its_shape_is_played_back_at_once(make_tank, fault):
    tank = make_tank("emperor_angelfish").put("swim_medium")
    tank.to_live()
    before = tank.step(60)
    tank.live.v[0, 21] = (0.0, 0.0, 400.0) if fault == "torn" else np.nan
    path = np.concatenate([before, tank.step(60)])
    assert not tank.fishes.live[0]
    assert tank.live.fish[0] == -1
    assert _steps(path).max() <= 1.3 * _steps(before).max()


def test_the_slot_is_kept_until_the_glide_is_over(make_tank):
    tank = make_tank("fusilier").put("swim_slow")
    tank.to_live()
    tank.run(20)
    tank.leave()
    recorded = len(tank.library.entry)
    while tank.live.fish[0] >= 0:
        tank.run(1)
    rows = [tank.fishes.row_a, tank.fishes.row_b, tank.fishes.previous_row_a]
    assert max(int(row[0]) for row in rows) < recorded


def test_fishes_in_sharp_turns_or_glides_are_not_taken(make_tank):
    assert not may_go_live(*_fish(make_tank, "turn_left_sharp"), 0)
    fishes, library = _fish(make_tank, "swim_fast")
    assert may_go_live(fishes, library, 0)
    fishes.span[:] = 6
    assert not may_go_live(fishes, library, 0)


def _fish(make_tank, name):
    tank = make_tank("fusilier").put(name)
    return tank.fishes, tank.library


def _world(**options):
    """The bay with few specks and leaves, which would cost half of a tick."""
    bay = load_scenario("peaceful", ["water.plankton=300", "seaweed=[]"]).scenario
    return create_world(bay, seed=5, **options)


@pytest.mark.nightly
def test_the_nearest_are_simulated_and_no_more_than_asked_for():
    world = _world(live=8)
    fishes = world.state.fishes
    since = np.full(len(fishes.live), -np.inf)
    simulated = 0
    for tick in range(600):
        was = fishes.live.copy()
        step(world, NEUTRAL)
        assert fishes.live.sum() <= (world.state.live.fish >= 0).sum() <= 8
        changed = was != fishes.live
        # A fish that begins to row or to flee leaves at once.
        settled = changed & (fishes.live | steady(fishes, world.library))
        assert (tick - since[settled] > MIN_STAY_S / TICK - 2).all()
        since[changed] = tick
        simulated += fishes.live.sum()
    assert simulated > 0
    away = np.linalg.norm(fishes.position - world.state.submarine.position, axis=1)
    reach = world.dynamics.reach_cm
    assert (away[fishes.live] < KEEP * reach + 100).all()


def test_nobody_is_simulated_far_away_or_without_a_budget():
    for world in (_world(live=8, live_reach_cm=1.0), _world()):
        for _ in range(200):
            step(world, NEUTRAL)
        assert not world.state.fishes.live.any()


@pytest.mark.parametrize("fish", [0, 1])
def test_slots_may_be_more_than_fishes(fish):
    world = _world(fish=fish, live=4, live_reach_cm=np.inf)
    for _ in range(30):
        step(world, NEUTRAL)
    assert world.state.fishes.live.sum() <= fish


@pytest.mark.nightly
def test_half_a_minute_of_nothing_but_simulation():
    """Live fishes that swim steadily: all sound, inside the sea and as fast as asked."""
    number = 60
    world = _world(fish=number, live=number, live_reach_cm=np.inf)
    fishes, bounds = world.state.fishes, world.scenario.bounds
    steadily, swum, asked = np.ones(number, np.bool_), [], []
    fast = world.library.speed[fishes.species, 2] * fishes.scale * fishes.rate
    for tick in range(950):
        step(world, Helm(surge=0.4, yaw=0.1))
        steadily &= steady(fishes, world.library)
        if tick > 300:
            swum.append(np.linalg.norm(fishes.velocity[fishes.live], axis=1).sum())
            asked.append((fishes.goal_speed * fast)[fishes.live].sum())
    assert steadily.mean() > 0.2
    assert fishes.live[steadily].all()
    assert (fishes.stay[steadily] > 30.0).all()
    assert np.isfinite(fishes.position).all()
    assert np.hypot(fishes.position[:, 0], fishes.position[:, 1]).max() < bounds.radius_cm
    assert sum(swum) == pytest.approx(sum(asked), rel=0.25)


def test_nodes_lie_where_the_simulation_has_them(make_tank):
    tank = make_tank("fusilier", 1.3).put("swim_fast")
    tank.to_live()
    tank.run(20)
    nodes = nodes_world(tank.fishes, tank.library, 0)
    expected = tank.fishes.position[0] + tank.fishes.scale[0] * tank.live.x[0]
    np.testing.assert_allclose(nodes, expected, atol=1e-3)


def test_a_spine_driven_fish_is_never_simulated():
    """It is played back however near it is; muscular fishes around it are simulated."""
    scenario = load_scenario("peaceful").scenario
    here = scenario.submarine.position_cm
    shoals = [
        Shoal(species=name, number=3, position_cm=here, spread_cm=100.0)
        for name in ("ribbon_eel", "fusilier")
    ]
    scenario = msgspec.structs.replace(scenario, fish=shoals)
    world = create_world(scenario, seed=5, live=6, live_reach_cm=1e4)
    names, most = np.array([one.name for one in world.species]), 0
    for _ in range(200):
        step(world, NEUTRAL)
        fishes = world.state.fishes
        assert set(names[fishes.species[fishes.live]]) <= {"Yellowback fusilier"}
        most = max(most, fishes.live.sum())
    assert most == 3
    assert np.isfinite(fishes.position).all()
