"""Outcrops and arches: rocks that hold together, and leave the way free."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.habitat.contact import clearances
from subsea.habitat.formations import formations
from subsea.habitat.rocks import arch, outcrop, rock_rows, single, wreck
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import (
    MAX_SOLIDS,
    Arch,
    Outcrop,
    Rock,
    Scenario,
    Shoal,
    Start,
    Terrain,
    Wreck,
)
from subsea.state import HULL_CM, Submarine
from subsea.submarine.vessel import NEUTRAL, Helm, step_hull
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.seas import bare_sea

NO_PILLARS = np.zeros((0, 4))
SEED = st.integers(0, 2**32 - 1)


def level(x, y):
    return -600.0


def slanting(x, y):
    return -600.0 + 0.1 * x - 0.06 * y


@given(SEED, st.integers(1, 20), st.floats(-180, 180))
def test_an_outcrop_is_one_formation_within_its_size(seed, number, yaw):
    one = Outcrop(
        position_cm=(50, 60), size_cm=(160, 110, 140), rocks=number, yaw_deg=yaw, seed=seed
    )
    rows = outcrop(one, slanting)
    assert rows.shape == (number, 7)
    np.testing.assert_array_equal(rows, outcrop(one, slanting))
    assert len(formations(NO_PILLARS, rows)) == 1
    assert (rows[:, 2] + rows[:, 5]).max() <= slanting(50, 60) + 140.0 + 1e-6
    assert np.hypot(*(rows[:, :2] - (50, 60)).T).max() + rows[:, 3:5].min() < 180.0


@given(SEED, st.floats(220, 600), st.floats(160, 450), st.floats(40, 200), st.floats(-180, 180))
def test_an_arch_stands_and_is_open(seed, span, height, thick, yaw):
    one = Arch(position_cm=(50, 60), span_cm=span, height_cm=height, thickness_cm=thick,
               yaw_deg=yaw, seed=seed)  # fmt: skip
    rows = arch(one, slanting)
    assert len(formations(NO_PILLARS, rows)) == 1
    along = np.array([np.cos(np.radians(yaw)), np.sin(np.radians(yaw))])
    ground = slanting(50, 60)
    rng = np.random.default_rng(seed)
    turn, away = rng.uniform(0, np.pi, 300), rng.uniform(0, 0.98, 300)
    across = (0.5 * span * away * np.cos(turn))[:, None] * along
    inside = np.column_stack([across + (50, 60), ground + height * away * np.sin(turn)])
    high = inside[:, 2] > ground + 0.25 * height  # on a slope a foot may reach in a little
    assert clearances(NO_PILLARS, rows, inside[high]).min() > 0.0
    # Both legs reach the sand.
    for sign in (-1.0, 1.0):
        foot = np.array([50, 60]) + sign * (0.5 * span + 0.5 * thick) * along
        place = np.array([[*foot, slanting(*foot) + 5.0]])
        assert clearances(NO_PILLARS, rows, place)[0] < 0.0


@pytest.mark.parametrize("seed", range(4))
def test_the_hull_passes_through_the_least_arch_and_through_no_stone(seed):
    rows = arch(Arch(position_cm=(0, 0), span_cm=220, height_cm=160, yaw_deg=90, seed=seed), level)

    around = bare_sea(level(0.0, 0.0), rocks=rows)

    def steer(y):
        hull = Submarine(position=np.array([-400.0, y, -525.0]))
        nearest = np.inf
        for _ in range(500):
            step_hull(hull, Helm(surge=1.0), 0.033, around)
            nearest = min(nearest, clearances(NO_PILLARS, rows, hull.position[None])[0])
        return hull.position, nearest

    place, nearest = steer(0.0)
    assert place[0] > 200.0
    assert nearest > 0.4 * HULL_CM
    place, nearest = steer(160.0)  # into a leg
    assert nearest > 0.4 * HULL_CM


def test_a_school_swims_through_and_into_no_stone():
    base = load_scenario("peaceful")[0]
    school = Shoal(
        species="fusilier", number=12, position_cm=(-330.0, 0.0, -500.0), spread_cm=60,
        heading_deg=0, toward_cm=(600.0, 0.0, -500.0), hunger=0.0, digestion=1e-4,
    )  # fmt: skip
    scenario = Scenario(
        title="An arch", seed=1, bounds=base.bounds, fish=[school],
        water=msgspec.structs.replace(base.water, plankton=0),
        terrain=Terrain(dune_height_cm=20, dune_length_cm=900, seed=3),
        submarine=Start(position_cm=(-900.0, 0.0, -300.0)),
        arch=[Arch(position_cm=(0.0, 0.0), span_cm=350, height_cm=250, yaw_deg=90, seed=1)],
    )  # fmt: skip
    world = create_world(scenario)
    sea, fishes = world.state.sea, world.state.fishes
    through, nearest = np.zeros(12, np.bool_), np.inf
    for _ in range(800):
        before = fishes.position[:, 0].copy()
        step(world, NEUTRAL)
        places = fishes.position.astype(np.float64)
        nearest = min(nearest, clearances(sea.pillars, sea.rocks, places).min())
        through |= (before < 0.0) & (places[:, 0] >= 0.0) & (np.abs(places[:, 1]) < 175.0)
    assert through.sum() >= 10
    assert nearest > 10.0


def test_a_rock_may_lie_above_the_sand():
    low = Rock(position_cm=(1, 2), size_cm=(30, 20, 10))
    high = Rock(position_cm=(1, 2), size_cm=(30, 20, 10), height_cm=150.0)
    assert single(low, level)[0, 2] == pytest.approx(-596)
    assert single(high, level)[0, 2] == -450.0


def test_every_rock_knows_its_table():
    scenario = msgspec.structs.replace(
        load_scenario("peaceful")[0],
        rock=[Rock(position_cm=(1, 2), size_cm=(30, 20, 10))],
        outcrop=[Outcrop(position_cm=(1, 2), size_cm=(30, 20, 10), rocks=3)],
        ridge=[],
        arch=[Arch(position_cm=(1, 2), span_cm=300, height_cm=200)],
    )
    rows, names = rock_rows(scenario, level)
    assert len(rows) == len(names)
    assert names[:5] == ["`rock[0]`", *3 * ["`outcrop[0]`"], "`arch[0]`"]


@given(SEED, st.floats(600, 3000), st.floats(0.0, 1.0), st.floats(-180, 180))
def test_a_wreck_lies_on_the_sand_and_its_hold_is_open(seed, length, broken, yaw):
    one = Wreck(position_cm=(50, 60), length_cm=length, width_cm=0.3 * length,
                height_cm=0.18 * length, mast_cm=0.5 * length, broken=broken, yaw_deg=yaw,
                seed=seed)  # fmt: skip
    rows = wreck(one, slanting)
    np.testing.assert_array_equal(rows, wreck(one, slanting))
    assert len(rows) <= MAX_SOLIDS
    assert np.hypot(*(rows[:, :2] - (50, 60)).T).max() < 0.65 * length
    ground = np.array([slanting(x, y) for x, y in rows[:, :2]])
    assert (rows[:, 2] + rows[:, 5] - ground).max() < 0.5 * length + 0.1 * length
    hold = np.array([[50.0, 60.0, slanting(50, 60) + 0.6 * 0.18 * length]])
    assert clearances(NO_PILLARS, rows, hold).min() > 0.05 * length
