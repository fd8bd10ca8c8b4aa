"""The submarine among fishes: they part round its hull, and a cleaner comes to its window."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.geometry.rotation import x_axis
from subsea.lab.schooling import spread
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.state import HULL_CM, SUBMARINE
from subsea.state.feelings import feel
from subsea.submarine.vessel import NEUTRAL, STATION, Helm
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S
from tests.support.daily import only


def ticks(seconds):
    return range(round(seconds / TICK_S))


def gaps(world):
    """Distances (n,) of the fishes from the hull, cm: of snout, middle or tail, the nearest."""
    fishes, hull = world.state.fishes, world.state.submarine.position
    ahead = np.array([x_axis(q) for q in fishes.orientation])
    snout = fishes.position + fishes.snout[:, None] * ahead
    parts = snout, fishes.position, snout - fishes.length[:, None] * ahead
    return np.min([np.linalg.norm(part - hull, axis=1) for part in parts], axis=0) - HULL_CM


def toward(submarine, place):
    """A helm at full thrust toward a place."""
    way = place - submarine.position
    turn = math.atan2(way[1], way[0]) - submarine.angles[0]
    turn = (turn + math.pi) % (2.0 * math.pi) - math.pi
    climb = math.atan2(way[2], math.hypot(way[0], way[1])) - submarine.angles[1]
    yaw, pitch = (float(np.clip(2.0 * angle, -1.0, 1.0)) for angle in (turn, climb))
    return Helm(surge=1.0 if abs(turn) < 0.6 else 0.2, yaw=yaw, pitch=pitch)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", only([22], [21, 22]))
def test_a_school_parts_round_the_hull_and_closes_behind_it(seed):
    world = create_world(load_scenario("schooling", ["seaweed=[]"]).scenario, seed=seed)
    submarine, fishes = world.state.submarine, world.state.fishes
    nearest, through = math.inf, False
    for _ in ticks(40.0):
        middle = np.median(fishes.position, axis=0)
        step(world, toward(submarine, middle))
        nearest = min(nearest, gaps(world).min())
        through = np.linalg.norm(middle - submarine.position) < 70.0
        if through:
            break
    assert through
    together = 0.0
    for tick in ticks(20.0):
        step(world, Helm(surge=1.0) if tick < 60 else STATION)
        if tick % 10 == 0:
            nearest = min(nearest, gaps(world).min())
            place, length = fishes.position.astype(np.float64), fishes.length.astype(np.float64)
            together = max(together * (tick > 90), spread(place, length, 6.0, fishes.period)[1])
    assert nearest > 0.0  # none touches the hull
    assert together > 0.9  # of the fishes, at once within 20 s


@pytest.mark.nightly
@pytest.mark.parametrize("seed", only([3], [3, 4]))
def test_a_cleaner_that_likes_the_submarine_hovers_before_its_window_and_picks(seed):
    scenario = load_scenario("peaceful", ["seaweed=[]"]).scenario
    place = tuple(np.add(scenario.submarine.position_cm, (230.0, 40.0, -60.0)))
    wrasse = Shoal(species="moon_wrasse", number=1, position_cm=place, hunger=0.0)
    world = create_world(replace(scenario, fish=[wrasse], tour=[], individual=[]), seed=seed)
    minds, fishes = world.state.minds, world.state.fishes
    feel(minds, 0, SUBMARINE, 0.5)
    minds.itch[0] = 0.9
    near, picks, ahead = [], 0, []
    for _ in ticks(35.0):
        step(world, NEUTRAL)
        if minds.client[0] == SUBMARINE:
            gap = float(gaps(world)[0])
            near.append(gap)
            if gap < 30.0:
                picks += fishes.gape[0] > 0.0
                way = fishes.position[0] - world.state.submarine.position
                ahead.append(way @ (math.cos(world.state.submarine.angles[0]),
                                    math.sin(world.state.submarine.angles[0]), 0.0)
                             / np.linalg.norm(way))  # fmt: skip
    assert min(near) > 0.0
    assert np.sum(np.array(near) < 30.0) * TICK_S > 6.0
    assert picks * TICK_S > 3.0
    assert np.median(ahead) > 0.8  # in sight of the pilot
