"""Rotation of a school, and its states."""

import numpy as np
import pytest

from subsea.lab.schooling import School, rotation_of, states

ANGLE = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
RING = 50.0 * np.stack([np.cos(ANGLE), np.sin(ANGLE), 0.0 * ANGLE], axis=1)
ROUND = np.stack([-np.sin(ANGLE), np.cos(ANGLE), 0.0 * ANGLE], axis=1)


def test_a_ring_that_turns_one_way_rotates_fully():
    assert rotation_of(RING + (10.0, -20.0, 5.0), ROUND) == pytest.approx(1.0)
    assert rotation_of(RING, -ROUND) == pytest.approx(1.0)


def test_parallel_and_divided_schools_do_not_rotate():
    parallel = np.tile([1.0, 0.0, 0.0], (24, 1))
    half = np.where(np.arange(24)[:, None] % 2, ROUND, -ROUND)
    assert rotation_of(RING, parallel) == pytest.approx(0.0, abs=1e-9)
    assert rotation_of(RING, half) == pytest.approx(0.0, abs=1e-9)


def test_states_are_shares_of_the_calm_samples():
    """An alarmed sample and one between the states count for none."""
    order, turning = np.array([0.9, 0.2, 0.1, 0.5, 0.9]), np.array([0.1, 0.8, 0.2, 0.5, 0.1])
    calm, empty = np.array([True, True, True, True, False]), np.zeros(5)
    school = School(
        leader=0, time=np.arange(5.0), members=np.full(5, 24), calm=calm, cruises=calm,
        polarisation=order, rotation=turning, course=empty, nearest=empty, together=empty,
        extent=empty, distances=empty,
    )  # fmt: skip
    assert states(school) == {"polarised": 0.25, "milling": 0.25, "swarm": 0.25}
