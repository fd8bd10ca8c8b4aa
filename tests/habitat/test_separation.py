"""Bodies that come close are parted softly."""

import itertools

import numpy as np
import pytest

from subsea.geometry.vector import vector
from subsea.habitat.clearance import clearance
from subsea.habitat.separation import FULL_CM_S, RIM_CM, STONE_CM, keep_off_solids, separate
from subsea.state import CIRCLING, PREDATOR


def _pair(tank, gap):
    t = tank(2)
    t.fishes.girth[:] = 6.0, 3.0
    t.fishes.position[1] += gap
    t.minds.neighbour[0, 0], t.minds.neighbour[1, 0] = 1, 0
    return t


@pytest.mark.parametrize("gap", [(0.0, 4.6, 0.0), (0.0, -4.6, 0.0), (9.0, 3.0, 3.0)])
def test_two_that_nearly_touch_are_pushed_apart_alike(tank, gap):
    t = _pair(tank, gap)
    separate(t.fishes, t.minds)
    first, second = t.fishes.drift
    np.testing.assert_allclose(first, -second, atol=1e-5)
    assert second @ np.array(gap) > 0
    assert np.linalg.norm(second) <= FULL_CM_S + 1e-4


def test_the_push_grows_as_they_come_closer_and_begins_at_nothing(tank):
    speeds = []
    for gap in (7.5, 6.8, 6.0, 5.0, 4.0):
        t = _pair(tank, (0.0, gap, 0.0))
        separate(t.fishes, t.minds)
        speeds.append(t.fishes.drift[1, 1])
    assert speeds[0] == 0
    assert all(a < b for a, b in itertools.pairwise(speeds))


def test_one_behind_the_other_is_measured_from_snout_to_tail(tank):
    """Middles 22 cm apart are snout and tail 2 cm apart."""
    for gap, pushed in ((22.0, True), (28.0, False)):
        t = _pair(tank, (gap, 0.0, 0.0))
        separate(t.fishes, t.minds)
        assert (t.fishes.drift[1, 0] > 0) == pushed


def test_partners_that_dance_are_let_alone(tank):
    t = _pair(tank, (0.0, 4.0, 0.0))
    t.minds.courtship[0] = CIRCLING
    separate(t.fishes, t.minds)
    np.testing.assert_array_equal(t.fishes.drift[0], 0)
    assert t.fishes.drift[1, 1] > 0


def test_no_prey_is_pushed_out_of_a_hunters_mouth(tank):
    t = _pair(tank, (0.0, 4.0, 0.0))
    t.minds.kind[0] = PREDATOR
    separate(t.fishes, t.minds)
    assert not t.fishes.drift.any()


ROCKS = np.array([[0.0, 60, -300, 70, 50, 80, 0.3], [0.0, -60, -300, 70, 50, 80, -0.3]])
PILLARS = np.array([[300.0, 0.0, 50.0, -100.0]])


@pytest.mark.parametrize("way", [(-1.0, 0.0, 0.0), (-0.8, 0.6, 0.0), (-0.6, 0.0, -0.8)])
def test_nobody_swims_into_stone_not_even_into_a_cleft(tank, way):
    t = tank(1)
    sea = t.sea._replace(rocks=ROCKS, pillars=PILLARS)
    t.fishes.position[0] = np.array([10.0, 0.0, -300.0]) - 90.0 * np.array(way)
    for _ in range(400):
        t.fishes.drift[:] = 0.0
        keep_off_solids(t.fishes, sea)
        t.fishes.position[0] += 0.033 * (t.fishes.drift[0] + 25.0 * np.array(way, np.float32))
        assert clearance(PILLARS, ROCKS, vector(t.fishes.position[0])) > 0.0


def test_stone_is_felt_only_near_by(tank):
    t = tank(1)
    sea = t.sea._replace(rocks=ROCKS[:0], pillars=PILLARS)
    for gap, felt in ((STONE_CM + 0.5, False), (STONE_CM - 0.5, True)):
        t.fishes.position[0] = 250.0 - gap - t.fishes.snout[0], 0.0, -300.0
        t.fishes.drift[:] = 0.0
        keep_off_solids(t.fishes, sea)
        assert (t.fishes.drift[0, 0] < 0.0) == felt


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (-0.6, 0.8, 0.0), (0.0, -0.9, 0.4)])
def test_nobody_is_driven_beyond_the_rim(tank, way):
    """However one flees toward it, and the current with it."""
    t = tank(1)
    outward = np.array(way[:2]) / np.hypot(*way[:2])
    t.fishes.position[0, :2] = (t.sea.radius - RIM_CM - 1.0) * outward
    keep_off_solids(t.fishes, t.sea)
    assert (t.fishes.drift == 0.0).all()
    for _ in range(100):
        t.fishes.drift[:] = 0.0
        keep_off_solids(t.fishes, t.sea)
        t.fishes.position[0] += 0.033 * (t.fishes.drift[0] + 90.0 * np.array(way, np.float32))
        assert np.hypot(*t.fishes.position[0, :2]) < t.sea.radius
