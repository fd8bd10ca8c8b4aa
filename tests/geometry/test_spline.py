"""The basis tables against scipy."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from subsea.geometry.curves import basis_at, basis_table, decimated, dense, greville, through


def _scipy(controls, samples, degree):
    spans = controls - degree
    knots = np.concatenate([np.zeros(degree), np.linspace(0, 1, spans + 1), np.ones(degree)])
    return BSpline(knots, np.eye(controls), degree), np.linspace(0, 1, samples)


def _dense(table, values, controls):
    out = np.zeros((len(table.first), controls + 3))
    for j in range(3):
        out[np.arange(len(out)), table.first + j] += values[:, j]
    assert (out[:, controls:] == 0).all()
    return out[:, :controls]


@pytest.mark.parametrize(("controls", "degree"), [(9, 2), (21, 2), (12, 2), (4, 2), (2, 1), (3, 2)])
@pytest.mark.parametrize("samples", [2, 17, 41])
def test_values_and_slopes_are_those_of_scipy(controls, degree, samples):
    table = basis_table(controls, samples, degree)
    spline, t = _scipy(controls, samples, degree)
    np.testing.assert_allclose(_dense(table, table.weight, controls), spline(t), atol=1e-12)
    np.testing.assert_allclose(
        _dense(table, table.slope, controls), spline.derivative()(t), atol=1e-10
    )


@pytest.mark.parametrize("controls", [9, 21])
def test_a_partition_of_unity_that_holds_the_ends(controls):
    table = basis_table(controls, 33)
    np.testing.assert_allclose(table.weight.sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(table.slope.sum(axis=1), 0.0, atol=1e-10)
    assert (table.weight > -1e-15).all()
    assert table.weight[0, 0] == pytest.approx(1)
    assert table.weight[-1, -1] == pytest.approx(1)


def test_a_coarser_level_is_a_subset_of_the_finest():
    fine, coarse = basis_table(21, 41), basis_table(21, 21)
    for a, b in zip(decimated(fine, slice(None, None, 2)), coarse, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)


def test_invalid_bases_are_refused():
    with pytest.raises(ValueError, match="degree 3"):
        basis_table(9, 5, 3)


def test_a_spline_goes_through_points():
    points = np.random.default_rng(0).normal(size=(12, 3))
    control = through(points)
    np.testing.assert_allclose(dense(basis_at(12, greville(12)), 12) @ control, points, atol=1e-12)


def test_parameters_of_control_points_reproduce_the_parameter():
    t = np.linspace(0, 1, 33)
    np.testing.assert_allclose(dense(basis_table(9, 33), 9) @ greville(9), t, atol=1e-12)
