"""Food from the submarine, and the fishes that come for it."""

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.state import SUBMARINE
from subsea.state.feelings import feeling_for
from subsea.submarine.vessel import NEUTRAL, hull_axes
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.feeding import AHEAD_CM, EVERY_S, PINCH, SPREAD_CM, scatter_food
from subsea.world.step import step
from subsea.world.world import TICK_S


def without_seaweed():
    """The bay; its seaweed is slow, and irrelevant here."""
    return load_scenario("peaceful", ["seaweed=[]"]).scenario


def bay(specks=300, **keys):
    scenario = without_seaweed()
    place = np.add(scenario.submarine.position_cm, (260.0, 0.0, 30.0))
    shoal = Shoal(species="blue_tang", number=10, position_cm=tuple(place), hunger=0.9, **keys)
    water = replace(scenario.water, plankton=specks)
    return create_world(
        replace(scenario, fish=[shoal], tour=[], individual=[], water=water), seed=2
    )


def run(world, seconds):
    for _ in range(round(seconds / TICK_S)):
        step(world, NEUTRAL)


def test_a_pinch_lies_before_the_window_and_sinks():
    world = bay()
    sea = world.state.sea
    eaten = np.array([3, 5])
    sea.absent[eaten] = 30.0
    assert scatter_food(world)
    food = np.flatnonzero(sea.absent < 0.0)
    assert len(food) == PINCH and set(eaten) <= set(food)
    before = world.state.submarine.position + np.multiply(
        AHEAD_CM, hull_axes(*world.state.submarine.angles)[0]
    )
    assert np.abs(sea.plankton[food] - before).max() <= SPREAD_CM
    height = sea.plankton[food, 2].copy()
    snapshot.check(world)
    run(world, 2.0)
    fell = height - sea.plankton[food, 2]
    assert 4.0 < np.median(fell[sea.absent[food] < 0.0]) < 14.0


def test_food_is_scattered_at_a_limited_rate_and_needs_plankton():
    world = bay()
    given = 0
    for _ in range(round(20.0 / TICK_S)):
        given += scatter_food(world)
        step(world, NEUTRAL)
    assert given == pytest.approx(20.0 / EVERY_S, abs=1)
    assert not scatter_food(bay(specks=0))


def test_the_same_tick_gives_the_same_food():
    worlds = bay(), bay()
    for world in worlds:
        scatter_food(world)
        run(world, 1.0)
    assert snapshot.checksum(worlds[0]) == snapshot.checksum(worlds[1])


@pytest.mark.nightly
@pytest.mark.parametrize(("hunger", "comes"), [(0.5, True), (0.0, False)])
def test_a_school_leaves_its_way_for_food_unless_it_is_full(hunger, comes):
    scenario = without_seaweed()
    place = tuple(np.add(scenario.submarine.position_cm, (420.0, 60.0, 20.0)))
    shoal = Shoal(species="fusilier", number=12, position_cm=place, hunger=hunger, digestion=1e-5)
    scenario = replace(scenario, fish=[shoal], tour=[], individual=[])
    world = create_world(scenario, seed=5)
    assert scatter_food(world)
    pinch = np.flatnonzero(world.state.sea.absent < 0.0)
    run(world, 20.0)
    eaten = (world.state.sea.absent[pinch] > 0.0).sum()
    assert eaten >= 6 if comes else eaten == 0


def test_fed_fishes_like_the_submarine_and_come():
    liking = []
    for feeds in (False, True):
        world = bay(specks=60, timidity=(1.0, 0.0))
        world.nature = world.nature._replace(curiosity_cm=0.0)  # for food alone
        for tick in range(round(40.0 / TICK_S)):
            if feeds and tick % 150 == 0:
                scatter_food(world)
            step(world, NEUTRAL)
        minds = world.state.minds
        liking.append([feeling_for(minds, i, SUBMARINE) for i in range(10)])
    without, fed = np.array(liking)
    assert (fed > 0.2).sum() >= 4
    assert fed.mean() > without.mean() + 0.15
