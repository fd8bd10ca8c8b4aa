"""Compare the grid with all pairs, for random points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.perception.grid import (
    CELLS_EACH,
    CELLS_MORE,
    FEW,
    farthest,
    make_grid,
    near_slots,
    nearest,
)

SEEDS = st.integers(0, 2**32 - 1)


def _nearest(grid, p, reach, but, k, guess=10.0):
    found, gaps = np.zeros(k, np.int32), np.zeros(k)
    nearest(grid, tuple(np.float32(p)), reach, but, found, gaps, guess)
    return found, gaps


def _scene(seed, n=80, spread=100.0):
    rng = np.random.default_rng(seed)
    points = rng.normal(0, spread, (n, 3)).astype(np.float32)
    chosen = np.flatnonzero(rng.uniform(0, 1, n) < 0.7)
    return points, chosen, tuple(rng.normal(0, 1.5 * spread, 3))


@given(SEEDS, st.sampled_from([20.0, 70.0, 1e4]), st.floats(0.0, 500.0))
def test_near_slots_hold_all_that_are_near_once(seed, cell, reach):
    points, chosen, p = _scene(seed, n=160)
    assert len(chosen) > FEW
    grid = make_grid(points, chosen, cell)
    slots = np.full(len(chosen), -1)
    found = list(grid.member[slots[: near_slots(grid, p, reach, slots)]])
    gaps = np.abs(points[chosen].astype(float) - p)
    near = chosen[np.linalg.norm(gaps, axis=1) <= reach]
    assert set(near) <= set(found)
    assert len(set(found)) == len(found)
    # Members without a cell within reach are not found.
    assert set(found) <= set(chosen[(gaps <= reach + grid.cell).all(axis=1)])


def test_all_of_a_few_points_are_near():
    points = np.random.default_rng(1).normal(0, 1e4, (FEW, 3)).astype(np.float32)
    slots = np.full(FEW, -1)
    grid = make_grid(points, np.arange(FEW), 10.0)
    assert near_slots(grid, (0.0, 0.0, 0.0), 1.0, slots) == FEW
    assert slots.tolist() == list(range(FEW))


@given(
    SEEDS,
    st.floats(10.0, 400.0),
    st.integers(1, 6),
    st.sampled_from([20, 160]),
    st.sampled_from([0.0, 15.0, 120.0, np.inf]),
)
def test_the_nearest_are_those_of_all_pairs(seed, reach, k, n, guess):
    """For few points and many, and whatever distance is guessed."""
    points, chosen, p = _scene(seed, n)
    points[:] = np.round(points, -1)  # equal distances, to test the order
    p = tuple(np.round(p, -1))
    but = int(chosen[0])
    found, gaps = _nearest(make_grid(points, chosen, 30.0), p, reach, but, k, guess)
    away = np.linalg.norm(points[chosen].astype(float) - p, axis=1)
    order = [(d, j) for d, j in sorted(zip(away, chosen, strict=True)) if j != but and d < reach]
    order = (order + [(np.inf, -1)] * k)[:k]
    np.testing.assert_allclose(gaps, [d for d, _ in order])
    np.testing.assert_array_equal(found, [j for _, j in order])


def test_a_few_points_far_apart_do_not_fill_the_memory():
    points = np.array([[-1e6, 0, 0], [1e6, 1e6, 1e6]], np.float32)
    grid = make_grid(points, np.arange(2), 1.0)
    assert len(grid.start) - 1 <= 2 * CELLS_EACH + CELLS_MORE
    assert list(_nearest(grid, (0.0, 0.0, 0.0), 1e7, -1, 2)[0]) == [0, 1]


def test_a_grid_may_be_empty():
    grid = make_grid(np.zeros((3, 3), np.float32), np.zeros(0, np.int64), 10.0)
    found, gaps = _nearest(grid, (5.0, 5.0, 5.0), 100.0, -1, 2)
    assert list(found) == [-1, -1]
    assert list(gaps) == [np.inf, np.inf]


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 1, 0, 2]])
def test_of_equal_distances_the_lower_index_comes_first(order):
    points = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, -1]], np.float32)
    grid = make_grid(points[order], np.arange(4), 0.7)
    assert list(_nearest(grid, (0.0, 0.0, 0.0), 2.0, -1, 3)[0]) == [0, 1, 2]


def test_the_farthest_of_those_found_before_is_the_first_guess():
    places = np.array([[3, 0, 0], [0, 4, 0], [0, 0, 1]], np.float32)
    here = (0.0, 0.0, 0.0)
    assert farthest(places, here, np.array([0, 1], np.int32)) == pytest.approx(4.0, rel=1e-5)
    assert farthest(places, here, np.array([2, 0], np.int32)) == pytest.approx(3.0, rel=1e-5)
    assert farthest(places, here, np.array([2, -1], np.int32)) == np.inf
