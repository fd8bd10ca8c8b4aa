"""Adjustments of a patch: homographies, fields of points, turns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.view.adjustment import (
    PatchAdjustment,
    field_at,
    folds,
    homography,
    is_convex,
    moved,
    resampled,
)

UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
PLACES = np.random.default_rng(1).uniform(0, 1, (200, 2))
SHIFTS = st.lists(st.floats(-0.2, 0.2), min_size=8, max_size=8)


@given(SHIFTS)
def test_a_homography_moves_corners_there_and_keeps_lines_straight(shifts):
    corners = UNIT + np.reshape(shifts, (4, 2))
    matrix = homography(corners)
    lit = moved(PatchAdjustment(matrix), UNIT)
    np.testing.assert_allclose(lit[:, :2] / lit[:, 2:], corners, atol=1e-9)
    line = np.linspace([0.1, 0.3], [0.9, 0.7], 5)
    lit = moved(PatchAdjustment(matrix), line)
    x, y = (lit[:, :2] / lit[:, 2:]).T
    area = (x[1:-1] - x[0]) * (y[-1] - y[0]) - (y[1:-1] - y[0]) * (x[-1] - x[0])
    np.testing.assert_allclose(area, 0.0, atol=1e-9)


def test_corners_that_stay_move_nothing_at_all():
    assert np.array_equal(homography(UNIT), np.eye(3))
    assert not PatchAdjustment(homography(UNIT)).moves


@given(st.integers(2, 9), st.integers(2, 9), st.floats(-1, 1), st.floats(-1, 1))
def test_shifts_that_grow_evenly_stay_so(rows, columns, across, up):
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    points = np.stack([across * x + up * y + 0.2, up * x - across * y], axis=-1)
    x, y = PLACES.T
    wanted = np.stack([across * x + up * y + 0.2, up * x - across * y], axis=-1)
    np.testing.assert_allclose(field_at(points, PLACES), wanted, atol=1e-9)
    np.testing.assert_allclose(resampled(points, rows, columns), points, atol=1e-12)


def test_a_point_moves_itself_in_full_others_not_and_its_surroundings_smoothly():
    points = np.zeros((5, 7, 2))
    points[2, 3] = 0.1, -0.05
    x, y = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 5))
    np.testing.assert_allclose(
        field_at(points, np.stack([x, y], axis=-1).reshape(-1, 2)).reshape(points.shape), points,
        atol=1e-12,
    )  # fmt: skip
    line = np.stack([np.linspace(0, 1, 2001), np.full(2001, 0.5)], axis=-1)
    shift = field_at(points, line)[:, 0]
    steps = np.diff(shift)
    assert np.abs(np.diff(steps)).max() < 0.02 * np.abs(steps).max()  # no crease
    assert np.abs(shift[line[:, 0] < 1 / 6 - 1e-9]).max() == 0.0  # beyond two cells


def test_a_turn_comes_last():
    points = np.zeros((2, 2, 2))
    points[1, 1] = 0.25, 0.0
    mirror = np.array([[-1.0, 0, 1], [0, 1, 0], [0, 0, 1]])
    lit = moved(PatchAdjustment(points=points, turn=mirror), np.array([[1.0, 1.0]]))
    np.testing.assert_allclose(lit, [[-0.25, 1.0, 1.0]])
    quarter = np.array([[0.0, 1, 0], [-1, 0, 1], [0, 0, 1]])
    assert (
        PatchAdjustment(turn=quarter).on_its_side and not PatchAdjustment(turn=mirror).on_its_side
    )


@pytest.mark.parametrize("shift", [0.3, 0.7, -0.7])
def test_corners_that_cross_are_found(shift):
    corners = UNIT.copy()
    corners[0] += shift
    assert is_convex(corners) == (shift < 0.5)


def test_a_point_beyond_its_neighbour_folds_the_picture():
    points = np.zeros((4, 4, 2))
    assert not folds(PatchAdjustment()) and not folds(PatchAdjustment(points=points))
    points[1, 1, 0] = 0.1
    assert not folds(PatchAdjustment(points=points))
    points[1, 1, 0] = 0.5
    assert folds(PatchAdjustment(points=points))
