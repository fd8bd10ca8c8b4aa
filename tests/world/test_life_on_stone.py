"""A minute on a reef: fishes feed on stone, nose down, and no body enters it."""

import msgspec
import numpy as np
import pytest

from subsea.geometry.rotation import matrix
from subsea.geometry.vector import vector
from subsea.habitat.formations import drawn_distance, formations
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.state import GRAZE, SHELTER
from subsea.submarine.vessel import STATION
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

MINUTE_S = 60.0
REACH_BL = 0.15  # farthest food from the snout at a bite
EVERY = 10  # ticks from one test of bodies against stone to the next


def shoal(species, x, y):
    return Shoal(
        species=species,
        number=2,
        position_cm=(x, y, -270.0),
        spread_cm=60.0,
        hunger=0.6,
        libido=0.0,
    )


def without_growth():
    """Seaweed and plankton are slow, and irrelevant here."""
    return load_scenario("mating", ["water.plankton=0", "seaweed=[]"]).scenario


@pytest.fixture(scope="module")
def lagoon():
    """World, bites (fish, distance over length, pitch in degrees), and gaps to drawn stone, cm."""
    scenario = without_growth()
    fish = [
        shoal("blue_tang", 380.0, 190.0),
        shoal("bluecheek_butterflyfish", 330.0, -220.0),
        shoal("moon_wrasse", 150.0, 40.0),
    ]
    world = create_world(msgspec.structs.replace(scenario, fish=fish))
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    stones = formations(sea.pillars, sea.rocks)
    bites, gaps, grazed = [], [], 0
    for tick in range(int(MINUTE_S / TICK_S)):
        before, site = sea.stock.copy(), minds.site.copy()
        # Mouths bite before bodies move.
        ahead = matrix(fishes.orientation.astype(np.float64))[..., 0]
        snout = fishes.position + fishes.snout[:, None] * ahead
        step(world, STATION)
        for s in np.flatnonzero(sea.stock < before):
            away = np.linalg.norm(snout - sea.site_place[s], axis=1) / fishes.length
            i = int(away.argmin())
            bites.append((i, away[i], np.degrees(np.arcsin(ahead[i, 2]))))
        grazed += int((minds.intention == GRAZE).sum())
        if tick % EVERY == 0:
            tail = snout - fishes.length[:, None] * ahead
            for i in np.flatnonzero(fishes.shell > 0.0):
                parts = (snout[i], fishes.position[i], tail[i])
                gaps.append(min(drawn_distance(b, vector(p)) for b in stones for p in parts))
        assert (site < len(before)).all()
    share = grazed / len(fishes.species) / int(MINUTE_S / TICK_S)
    return world, np.array(bites), np.array(gaps), share


def test_hungry_fishes_bite_with_their_snouts_at_the_food(lagoon):
    _, bites, _, share = lagoon
    assert len(bites) >= 15
    assert len(np.unique(bites[:, 0])) >= 4
    assert (bites[:, 1] <= REACH_BL).all()
    assert share > 0.2


def test_they_feed_with_the_nose_down(lagoon):
    _, bites, _, _ = lagoon
    assert np.median(bites[:, 2]) < -25.0


def test_no_body_enters_the_drawn_stone(lagoon):
    _, _, gaps, _ = lagoon
    assert len(gaps)
    assert np.mean(gaps < -0.5) < 0.002
    assert gaps.min() > -2.5


@pytest.mark.nightly
def test_fishes_of_a_reef_go_to_cover_for_the_night():
    scenario = without_growth()
    water = msgspec.structs.replace(scenario.water, hour=0.0)
    fish = [shoal("blue_tang", 380.0, 190.0), shoal("moon_wrasse", 380.0, 220.0)]
    world = create_world(msgspec.structs.replace(scenario, water=water, fish=fish))
    for _ in range(int(40.0 / TICK_S)):
        step(world, STATION)
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    hidden = np.flatnonzero(minds.intention == SHELTER)
    hidden = hidden[minds.cover[hidden] >= 0]
    away = np.linalg.norm(fishes.position[hidden] - sea.site_place[minds.cover[hidden]], axis=1)
    assert (away < 2.0 * fishes.length[hidden]).sum() >= 2
