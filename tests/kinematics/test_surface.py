"""The drawn surface at rest."""

import numpy as np
import pytest
from msgspec import structs

from subsea.kinematics.spline import basis_table, dense
from subsea.kinematics.surface import (
    CONTROL_POINTS,
    DORSAL,
    FIN_U,
    FIN_V,
    LEFT,
    RIGHT,
    VENTRAL,
    TailPlan,
    U,
    V,
    along,
    rest_control_points,
)
from subsea.species import load_species, species_names

LENGTH = 20.0
SNOUT = 5.0


@pytest.fixture(params=species_names())
def plan(request):
    return load_species(request.param).surface


@pytest.fixture
def points(plan):
    return rest_control_points(plan, LENGTH, SNOUT)


def drawn(points, patch, shape, samples=(33, 161)):
    u, v = (dense(basis_table(n, k, min(2, n - 1)), n) for n, k in zip(shape, samples, strict=True))
    return np.einsum("ai,bj,ijc->abc", u, v, points[patch].reshape(*shape, 3))


def test_the_points_of_the_paper(points):
    assert points.shape == (CONTROL_POINTS, 3) == (426, 3)
    assert np.isfinite(points).all()


def test_halves_are_mirrored_and_share_their_ridges(points):
    left, right = (points[patch].reshape(U, V, 3) for patch in (LEFT, RIGHT))
    np.testing.assert_array_equal(left, right * (1, 1, -1))
    np.testing.assert_array_equal(left[[0, -1]], right[[0, -1]])
    assert (right[1:-1, :, 2] > 0).all()


def test_the_ridges_have_no_crease(points):
    """The surface leaves either ridge sideways, so both halves share its tangent plane."""
    right = points[RIGHT].reshape(U, V, 3)
    body = slice(1, V - 8)
    for ridge, beside in ((0, 1), (-1, -2)):
        rise = np.abs(right[beside, body, 1] - right[ridge, body, 1])
        assert (rise < 0.02 * (right[beside, body, 2])).all()


def test_the_surface_meets_the_outline(plan, points):
    body = drawn(points, RIGHT, (U, V))
    behind = (SNOUT - body[..., 0]) / LENGTH
    for ridge, curve in ((0, plan.back), (-1, plan.belly)):
        expected = LENGTH * along(curve, behind[ridge])
        np.testing.assert_allclose(body[ridge, :, 1], expected, atol=0.012 * LENGTH)
    widest = LENGTH * max(width for _, width in plan.width)
    assert body[..., 2].max() == pytest.approx(widest, rel=0.03)


def test_it_reaches_from_the_snout_to_the_tail(plan, points):
    body = drawn(points, LEFT, (U, V))
    assert body[..., 0].max() == pytest.approx(SNOUT, abs=1e-9)
    far = max(distance for _, distance in plan.tail.edge)
    assert body[..., 0].min() == pytest.approx(SNOUT - far * LENGTH, abs=0.01 * LENGTH)


def test_the_tail_is_flat_and_forked_as_planned(plan, points):
    edge = drawn(points, RIGHT, (U, V))[:, -1]
    assert np.abs(edge[:, 2]).max() < 0.003 * LENGTH
    behind = (SNOUT - edge[[0, len(edge) // 2, -1], 0]) / LENGTH
    np.testing.assert_allclose(behind, plan.tail.edge_at(np.array([1.0, 0.0, -1.0])), atol=0.02)


def test_a_tail_may_have_a_longer_upper_lobe():
    plan = load_species("fusilier").surface
    tail = structs.replace(plan.tail, edge=[(-1.0, 0.92), (-0.2, 0.88), (1.0, 1.0)])
    belly = [point for point in plan.belly if point[0] < 0.9] + [(0.92, -0.11)]
    plan = structs.replace(plan, tail=tail, belly=belly)
    edge = drawn(rest_control_points(plan, 1.0, 0.0), RIGHT, (U, V))[:, -1]
    np.testing.assert_allclose(edge[0, :2], (-1.0, 0.142), atol=1e-6)
    np.testing.assert_allclose(edge[-1, :2], (-0.92, -0.11), atol=1e-6)


@pytest.mark.parametrize(
    "edge", [[(0.2, 0.9), (1.0, 1.0)], [(-1.0, 0.9), (0.5, 1.0)], [(-0.5, 0.9), (1.0, 1.0)]]
)
def test_the_edge_of_a_tail_is_whole(edge):
    with pytest.raises(ValueError, match="from 0 or -1 to 1"):
        TailPlan(begin=0.8, edge=edge)


def test_fins_stand_in_the_middle_plane_on_the_ridges(plan, points):
    for patch, fin, curve, side in (
        (DORSAL, plan.dorsal, plan.back, 1),
        (VENTRAL, plan.ventral, plan.belly, -1),
    ):
        rows = drawn(points, patch, (FIN_U, FIN_V), (2, 101))
        assert (rows[..., 2] == 0).all()
        base = along(curve, (SNOUT - rows[0, :, 0]) / LENGTH) * LENGTH
        assert (side * (base - rows[0, :, 1]) > 0).all()  # sunk
        highest = max(side * height for _, height in fin.edge)
        assert (side * rows[1, :, 1]).max() == pytest.approx(highest * LENGTH, rel=0.03)


def test_size_and_place_are_those_asked_for(plan, points):
    twice = rest_control_points(plan, 2 * LENGTH, 2 * SNOUT)
    np.testing.assert_allclose(twice, 2 * points, atol=1e-12)


def test_a_curve_meets_its_points_and_never_overshoots():
    curve = np.array([[0.0, 0.0], [0.1, 1.0], [0.3, 1.2], [0.7, 1.2], [1.0, -0.5]])
    np.testing.assert_allclose(along(curve, curve[:, 0]), curve[:, 1], atol=1e-12)
    fine = along(curve, np.linspace(-0.2, 1.2, 2001))
    assert fine.max() <= 1.2 + 1e-12
    assert fine.min() >= -0.5 - 1e-12
    slope = np.diff(along(curve, np.linspace(0, 1, 20001))) * 20000
    assert np.abs(np.diff(slope)).max() < 0.1  # C1
