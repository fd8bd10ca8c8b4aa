"""A hull on a rail: at the given position at once, and gently turned to the given gaze."""

import math

import numpy as np
import pytest

from subsea.state import Submarine
from subsea.submarine.vessel import GAZE, TURN_RAD_S, Rail, board, ride

DT = 0.033


def boat(heading=0.0):
    submarine = Submarine(position=np.array([1.0, 2.0, -300.0]))
    submarine.angles[:] = heading, 0.0
    return submarine


def rail(heading=0.0, pitch=0.0):
    return Rail(np.array([10.0, 20.0, -310.0]), np.array([30.0, 0.0, -5.0]), (heading, pitch))


def test_it_is_where_the_rail_is():
    submarine = boat()
    ride(submarine, rail(), DT)
    np.testing.assert_array_equal(submarine.position, [10.0, 20.0, -310.0])
    np.testing.assert_array_equal(submarine.previous_position, [1.0, 2.0, -300.0])
    np.testing.assert_array_equal(submarine.velocity, [30.0, 0.0, -5.0])


@pytest.mark.parametrize(("start", "goal"), [(0.0, 2.0), (0.0, -2.0), (3.0, -3.0), (9.5, 3.0)])
def test_it_turns_the_short_way_without_haste_or_overshoot(start, goal):
    submarine, way = boat(start), math.remainder(goal - start, math.tau)
    turned, rates = [], []
    for _ in range(round(20.0 / DT)):
        ride(submarine, rail(goal, 0.3), DT)
        turned.append((submarine.angles[0] - start) / way)
        rates.append(submarine.rates.copy())
    assert np.abs(rates).max() <= TURN_RAD_S + 1e-12
    jerks = np.abs(np.diff([[0.0, 0.0], *rates], axis=0)).max() / DT
    assert jerks < GAZE**2 * 2.0  # of an error of two radians at the most
    assert max(turned) < 1.02
    assert turned[-1] == pytest.approx(1.0, abs=1e-3)
    assert submarine.angles[1] == pytest.approx(0.3, abs=1e-3)


def test_boarding_is_immediate():
    submarine = boat()
    board(submarine, rail(0.5, 0.1), rail(0.6, 0.1)._replace(position=np.array([11.0, 20.0, 0.0])))
    np.testing.assert_array_equal(submarine.previous_position, [10.0, 20.0, -310.0])
    np.testing.assert_array_equal(submarine.previous_angles, [0.5, 0.1])
    np.testing.assert_array_equal(submarine.position, [11.0, 20.0, 0.0])
    np.testing.assert_array_equal(submarine.angles, [0.6, 0.1])
