"""Fishes dive into cover at a shadow, and clownfishes bathe in their anemone."""

import numpy as np
import pytest

from subsea.behavior import sheltering
from subsea.behavior.table import INTENTIONS
from subsea.state import ANEMONE, BATHE, BATHES, COVER, HIDES, NOBODY, SHELTER, SPAWNING


def covered(tank, n=1):
    """A tank with a crevice and an anemone before its fishes."""
    t = tank(n)
    sea = t.sea._replace(
        site_kind=np.array([COVER, ANEMONE], np.uint8),
        site_place=np.array([[100.0, 0.0, -320.0], [100.0, 30.0, -320.0]], np.float32),
        site_normal=np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], np.float32),
        site_growth=np.full(2, -1, np.int32), site_depth=np.zeros(2, np.float32),
        stock=np.ones(2, np.float32),
    )  # fmt: skip
    t.minds.ways[:], t.minds.cover[:] = HIDES, 0
    return t._replace(sea=sea)


def test_the_codes_are_those_of_the_table():
    assert (INTENTIONS[BATHE], INTENTIONS[SHELTER]) == ("bathe", "shelter")


def test_a_shadow_drives_a_fish_into_cover_for_a_while(tank):
    t = covered(tank, 3)
    t.minds.shadow[:] = 0.8, 0.0, 0.8
    t.minds.cover[2] = -1
    assert (t.desire(sheltering.desire) > 0.0).tolist() == [True, False, False]
    low, high = sheltering.HIDE_S
    assert low <= t.minds.wary[0] <= high
    t.minds.shadow[:], t.minds.pause[:] = 0.0, 0.9 * low
    assert t.desire(sheltering.desire)[0] > 0.0
    t.minds.pause[:] = high
    assert t.desire(sheltering.desire)[0] == 0.0


def test_no_shadow_alarms_a_fish_of_imposed_fear_or_a_directed_pair(tank):
    t = covered(tank, 4)
    t.minds.shadow[:] = 0.8
    t.minds.fright[:2] = 0.0, 1.0
    t.minds.betrothed[2:4] = 3, NOBODY
    assert (t.desire(sheltering.desire) > 0.0).tolist() == [False, True, False, True]


def test_by_night_it_rests_but_not_while_it_spawns(tank):
    t = covered(tank, 2)
    t.minds.dark[:] = True
    t.minds.courtship[1] = SPAWNING
    assert t.desire(sheltering.desire).tolist() == [pytest.approx(sheltering.REST), 0.0]


def test_it_hurries_there_and_stays_inside(tank):
    t = covered(tank)
    t.fishes.burst[:], t.minds.wary[:] = 1.5, 5.0
    t.run(sheltering.act)
    assert t.fishes.goal_speed[0] == pytest.approx(1.0)  # and no burst
    assert not t.fishes.close[0]
    t.fishes.position[:] = 98.0, 0.0, -320.0
    t.run(sheltering.act)
    assert t.fishes.close[0]
    assert t.fishes.goal_speed[0] == pytest.approx(sheltering.HOVERS)
    assert abs(t.minds.urge[0, 1]) > 0.3  # it turns by its fins, to look out of the crevice


def test_a_clownfish_bathes_for_a_part_of_each_cycle(tank):
    t = covered(tank)
    t.minds.ways[:], t.minds.cover[:] = BATHES, 1
    _, high = sheltering.CYCLE_S
    bathes = [t.at(tick).desire(sheltering.bathing_desire)[0] > 0 for tick in range(0, 30000, 60)]
    assert np.mean(bathes) == pytest.approx(sheltering.SHARE, abs=0.05)
    t.minds.cover[:] = -1
    assert not t.desire(sheltering.bathing_desire).any()
    assert high < 30000 * t.clock.dt


def test_it_wriggles_among_the_tentacles(tank):
    t = covered(tank)
    t.minds.ways[:], t.minds.cover[:] = BATHES, 1
    t.fishes.position[:] = 90.0, 30.0, -320.0
    sides = []
    for tick in range(0, 60):
        t.at(tick).run(sheltering.bathe)
        sides.append(t.minds.urge[0, 1])
    assert t.fishes.close[0]
    assert min(sides) < 0.0 < max(sides)
