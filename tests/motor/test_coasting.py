"""Burst and coast, turns in a coast, and turns by pectoral fins, of recorded fishes."""

import numpy as np
import pytest

from subsea.biomechanics.manoeuvres import body_bend
from subsea.fish.species import load_species, shipped_species
from subsea.motor.controller import through_water
from subsea.motor.playback import BASE, BURST, COAST, FAST, ROW
from tests.motor.conftest import TICK

MUSCULAR = [name for name in shipped_species() if load_species(name).muscles]
PACED = 2.4  # recorded frames a tick, of an adult


@pytest.fixture
def swim(make_tank):
    """A function: segments, speeds over fast and nodes (T, 23, 3) of a fish with a goal."""

    def run(species, speed, ticks=400, azimuth=0.0, identity=0.4, ram=0.0):
        tank = make_tank(species).put("swim_slow")
        fishes = tank.fishes
        fishes.identity[:], fishes.burst[:], fishes.rate[:] = identity, 3.0, PACED
        fishes.ram[:] = ram
        tank.aim(0.0, speed)
        tank.run(60)
        tank.aim(azimuth, speed)
        segments, speeds, nodes = [], [], []
        for _ in range(ticks):
            nodes.append(tank.step(1)[0])
            segments.append(int(fishes.segment[0]))
            speeds.append(through_water(fishes, 0) / PACED / tank.library.speed[0, FAST])
        return np.array(segments), np.array(speeds), np.array(nodes)

    return run


def _runs(mask):
    """Lengths of the whole runs of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask, [0]])))
    return np.diff(edges)[::2]


@pytest.mark.parametrize("species", ["fusilier", "hardyhead_silverside", "blue_tang"])
def test_a_fish_beats_and_coasts_around_the_speed_that_it_wants(swim, species):
    segments, speeds, nodes = swim(species, 0.7)
    coasts = BASE[segments] == COAST
    assert speeds.mean() == pytest.approx(0.7, rel=0.1)
    assert 0.1 < speeds.std() / speeds.mean() < 0.35
    assert 0.3 < coasts.mean() < 0.85
    seconds = np.median(_runs(coasts)) * TICK, np.median(_runs(~coasts)) * TICK
    assert 0.25 < seconds[0] < 2.0 and 0.1 < seconds[1] < 0.7  # tetras of 3 cm: .3–1.5, .1–.3
    # Nothing jerks: no change of the velocity of the middle of the body beyond 20 L/s².
    change = np.linalg.norm(np.diff(nodes[:, 5:9].mean(axis=1), 2, axis=0), axis=1)
    assert change.max() / TICK**2 < 40.0 * load_species(species).length_cm
    assert np.quantile(change, 0.95) / TICK**2 < 20.0 * load_species(species).length_cm


def test_each_fish_has_a_rhythm_of_its_own(swim):
    coasts = [BASE[swim("fusilier", 0.6, identity=i)[0]] == COAST for i in (0.05, 0.95)]
    calm, wide = (len(_runs(mask)) for mask in coasts)
    assert calm > wide


def test_a_coast_loses_speed_as_in_the_simulation(swim, shipped_library):
    """1 / speed grows by the recorded slowing."""
    library = shipped_library("fusilier")[2]
    segments, speeds, _ = swim("fusilier", 0.3, 600)
    own = library.speed[0, COAST] / library.speed[0, FAST]
    for begin in np.flatnonzero(np.diff((segments == COAST).astype(int)) == 1):
        end = begin + 32  # the glide from a beat is over after 24 ticks
        if (segments[begin + 1 : end + 1] == COAST).all():
            grown = own * (1.0 / speeds[end] - 1.0 / speeds[begin + 24])
            assert grown == pytest.approx(library.slowing[0, COAST] * PACED * 8, rel=0.1)
            break
    else:
        raise AssertionError("no long coast")


@pytest.mark.parametrize("species", MUSCULAR)
def test_from_any_grade_a_fish_in_a_hurry_goes_on_to_its_fastest_swim(make_tank, species):
    """A fusilier's fast swim is only 1.15 times as fast as its medium one."""
    for grade in ("slow", "medium", "fast"):
        tank = make_tank(species).put(f"swim_{grade}")
        tank.fishes.burst[:] = 3.0
        tank.aim(0.0, 3.0)
        tank.run(60)
        assert tank.fishes.segment[0] in (FAST, BURST), grade


def test_one_that_breathes_by_swimming_does_not_coast(swim):
    assert (BASE[swim("blacktip_reef_shark", 0.5, 200, ram=0.4)[0]] != COAST).all()


@pytest.mark.parametrize(("species", "speed", "base"), [("fusilier", 0.3, COAST),
                                                      ("clownfish", 0.3, ROW)])  # fmt: skip
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_without_a_beat_the_body_bends_into_the_turn_and_reaches_its_heading(
    swim, species, speed, base, side
):
    azimuth = side * np.radians(45.0)
    segments, _, nodes = swim(species, speed, 240, azimuth)
    seen = nodes[:, :, [0, 2, 1]] * (1, 1, -1)  # the axes of a simulation
    bends = side * body_bend(seen)
    held = BASE[segments] == base
    assert held.mean() > 0.5
    turn = held[:60]  # later it corrects its course
    assert bends[:60][turn].max() > 15.0 and bends[:60][turn].min() > -5.0
    way = nodes[-1].mean(axis=0) - nodes[-31].mean(axis=0)
    assert np.arctan2(way[1], way[0]) == pytest.approx(azimuth, abs=np.radians(7.0))
