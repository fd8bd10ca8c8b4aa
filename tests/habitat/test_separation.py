"""Bodies that come close are parted softly."""

import itertools

import numpy as np
import pytest

from subsea.habitat.contact import FULL_CM_S, separate
from subsea.state import CIRCLING, PREDATOR
from tests.support.scenes import everyone


def _pair(tank, gap):
    t = tank(2)
    t.fishes.girth[:] = 6.0, 3.0
    t.fishes.position[1] += gap
    t.minds.neighbour[0, 0], t.minds.neighbour[1, 0] = 1, 0
    return t


@pytest.mark.parametrize("gap", [(0.0, 4.6, 0.0), (0.0, -4.6, 0.0), (9.0, 3.0, 3.0)])
def test_two_that_nearly_touch_are_pushed_apart_alike(tank, gap):
    t = _pair(tank, gap)
    separate(everyone(t.fishes), t.fishes, t.minds)
    first, second = t.fishes.drift
    np.testing.assert_allclose(first, -second, atol=1e-5)
    assert second @ np.array(gap) > 0
    assert np.linalg.norm(second) <= FULL_CM_S + 1e-4


def test_the_push_grows_as_they_come_closer_and_begins_at_nothing(tank):
    speeds = []
    for gap in (7.5, 6.8, 6.0, 5.0, 4.0):
        t = _pair(tank, (0.0, gap, 0.0))
        separate(everyone(t.fishes), t.fishes, t.minds)
        speeds.append(t.fishes.drift[1, 1])
    assert speeds[0] == 0
    assert all(a < b for a, b in itertools.pairwise(speeds))


def test_one_behind_the_other_is_measured_from_snout_to_tail(tank):
    """Middles 22 cm apart are snout and tail 2 cm apart."""
    for gap, pushed in ((22.0, True), (28.0, False)):
        t = _pair(tank, (gap, 0.0, 0.0))
        separate(everyone(t.fishes), t.fishes, t.minds)
        assert (t.fishes.drift[1, 0] > 0) == pushed


def test_partners_that_dance_are_let_alone(tank):
    t = _pair(tank, (0.0, 4.0, 0.0))
    t.minds.courtship[0] = CIRCLING
    separate(everyone(t.fishes), t.fishes, t.minds)
    np.testing.assert_array_equal(t.fishes.drift[0], 0)
    assert t.fishes.drift[1, 1] > 0


def test_no_prey_is_pushed_out_of_a_hunters_mouth(tank):
    t = _pair(tank, (0.0, 4.0, 0.0))
    t.minds.kind[0] = PREDATOR
    separate(everyone(t.fishes), t.fishes, t.minds)
    assert not t.fishes.drift.any()


def test_two_hunters_are_parted(tank):
    t = _pair(tank, (0.0, 4.6, 0.0))
    t.minds.kind[:] = PREDATOR
    t.minds.rival[:] = 1, 0
    separate(everyone(t.fishes), t.fishes, t.minds)
    first, second = t.fishes.drift
    np.testing.assert_allclose(first, -second, atol=1e-5)
    assert second[1] > 0
