"""Fishes that follow an odour upstream, and predators and prey that smell a catch."""

import numpy as np
import pytest

from subsea.behavior.threat_memory import ALARMING_SCENT, WARY, fear_of_scent
from subsea.behavior.tracking import CAST_S, LOST_S, SMELLS, track
from subsea.scenario.schema import (
    Bounds,
    Hook,
    Scenario,
    Shoal,
    Start,
    Terrain,
    Water,
)
from subsea.state import ALARM, BAIT_ODOUR, BLOOD, FEAR, HUNGER, PREDATOR
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

WAY = (0.0, 0.0, 1.0)


@pytest.fixture
def nose(tank):
    """A hungry scavenger in a stream along x, without an odour."""
    t = tank(1)
    t.minds.scavenges[0], t.minds.mental[0, HUNGER] = True, 1.0
    t.fishes.drift[0] = 5.0, 0.0, 0.0
    t.minds.pause[:] = TICK_S
    return t


def test_it_surges_upstream_in_the_plume_and_casts_across_when_it_is_lost(nose):
    t = nose
    t.minds.scent[0, BLOOD] = 10.0 * SMELLS
    t.minds.richer[0] = 0.0, 1.0, 0.0
    way, tracks = track(t.fishes, t.minds, 0, WAY)
    assert tracks
    assert way == pytest.approx((-1.0, 1.0, 0.0))
    t.minds.scent[0, BLOOD] = 0.0
    sides, ways = [], []
    for _ in range(int((CAST_S * 6 - 0.1) / TICK_S)):  # three casts
        way, tracks = track(t.fishes, t.minds, 0, WAY)
        assert tracks
        ways.append(way)
        sides.append(np.sign(way[1]))
    assert all(way[0] < 0.0 for way in ways)
    turns = np.flatnonzero(np.diff(sides)) * TICK_S
    assert turns == pytest.approx([CAST_S, 3.0 * CAST_S], abs=0.1)
    t.minds.trail[0] = LOST_S
    assert track(t.fishes, t.minds, 0, WAY) == (WAY, False)


def test_neither_sated_nor_other_fishes_follow(nose):
    t = nose
    t.minds.scent[0, BAIT_ODOUR] = 10.0 * SMELLS
    assert track(t.fishes, t.minds, 0, WAY)[1]
    t.minds.mental[0, HUNGER] = 0.1
    assert not track(t.fishes, t.minds, 0, WAY)[1]
    t.minds.mental[0, HUNGER], t.minds.scavenges[0] = 1.0, False
    assert not track(t.fishes, t.minds, 0, WAY)[1]
    t.minds.scavenges[0], t.minds.kind[0], t.minds.lull[0] = True, PREDATOR, 5.0
    assert not track(t.fishes, t.minds, 0, WAY)[1]


def a_bait(place, stream=(8.0, 0.0), species="moon_wrasse"):
    """A hungry fish at a place, in a stream past a bait at (-600, 0) that has hung for a while."""
    scenario = Scenario(
        title="bait",
        seed=1,
        bounds=Bounds(radius_cm=1500.0, depth_cm=500.0),
        water=Water(type="II", stream_cm_s=stream),
        terrain=Terrain(dune_height_cm=0.0, dune_length_cm=500.0),
        submarine=Start(position_cm=(0.0, 1400.0, -100.0)),
        fish=[Shoal(species=species, number=1, position_cm=place, spread_cm=1.0, hunger=1.0,
                    digestion=0.0, heading_deg=90.0)],
        hook=Hook(position_cm=(-600.0, 0.0), depth_cm=250.0, speed_cm_s=400.0, start_s=0.0),
    )  # fmt: skip
    world = create_world(scenario)
    world.nature = world.nature._replace(smell_cm=100.0, vision_cm=100.0, curiosity_cm=0.0)
    return world


def nearest(world, seconds):
    """Step a world; returns how near the fish came to the bait, cm."""
    least = np.inf
    start = world.state.fishes.position.copy()
    for tick in range(round(seconds / TICK_S)):
        step(world, NEUTRAL)
        if tick * TICK_S < 150.0:  # held in place until there is a plume
            world.state.fishes.position[:] = start
        gap = np.linalg.norm(world.state.fishes.position[0] - (-600.0, 0.0, -250.0))
        least = min(least, float(gap))
        if least < 100.0:
            break
    return least


@pytest.mark.nightly
def test_a_wrasse_finds_a_bait_from_ten_metres_downstream():
    world = a_bait((400.0, 0.0, -250.0))
    assert nearest(world, 260.0) < 100.0
    assert world.state.odour.total[BAIT_ODOUR] > 0.0


@pytest.mark.nightly
def test_nor_from_upstream_by_smell():
    world = a_bait((400.0, 0.0, -250.0), stream=(-8.0, 0.0))
    nearest(world, 155.0)
    assert world.state.minds.scent[0, BAIT_ODOUR] < SMELLS
    assert world.state.minds.trail[0] > LOST_S


def test_prey_that_smells_alarm_substance_is_more_vigilant(tank):
    assert fear_of_scent(0.0) == 0.0
    assert fear_of_scent(0.5 * ALARMING_SCENT) == pytest.approx(0.5 * WARY)
    assert fear_of_scent(100.0) == WARY < 0.25
    world = a_bait((0.0, 0.0, -250.0), species="fusilier")
    step(world, NEUTRAL)
    assert world.state.minds.mental[0, FEAR] == 0.0
    world.state.odour.total[ALARM] = 1.0
    world.state.odour.amount[ALARM] = 1.0
    for _ in range(9):  # far fishes think every eighth tick
        step(world, NEUTRAL)
    assert world.state.minds.mental[0, FEAR] == pytest.approx(WARY)


def test_the_scent_is_gone_with_the_odour():
    world = a_bait((0.0, 0.0, -250.0))
    world.state.minds.scent[:] = 0.1
    for _ in range(9):
        step(world, NEUTRAL)
    assert (world.state.minds.scent[0] < SMELLS).all()
