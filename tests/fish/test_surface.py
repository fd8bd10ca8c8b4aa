"""The drawn surface at rest."""

from itertools import pairwise

import msgspec
import numpy as np
import pytest
from msgspec import structs

from subsea.fish.species import load_species, species_names
from subsea.fish.surface import (
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
    WingPlan,
    along,
    rest_control_points,
)
from subsea.geometry.curves import basis_table, dense

LENGTH = 20.0
SNOUT = 5.0


def drawn(points, patch, shape, samples=(33, 161)):
    u, v = (dense(basis_table(n, k, min(2, n - 1)), n) for n, k in zip(shape, samples, strict=True))
    return np.einsum("ai,bj,ijc->abc", u, v, points[patch].reshape(*shape, 3))


@pytest.fixture(params=species_names())
def plan(request):
    return load_species(request.param).surface


def test_control_points_are_symmetric_scale_and_have_smooth_ridges(plan):
    points = rest_control_points(plan, LENGTH, SNOUT)
    assert points.shape == (CONTROL_POINTS, 3) == (426, 3)
    assert np.isfinite(points).all()
    np.testing.assert_allclose(
        rest_control_points(plan, 2 * LENGTH, 2 * SNOUT), 2 * points, atol=1e-12
    )
    left, right = (points[patch].reshape(U, V, 3) for patch in (LEFT, RIGHT))
    np.testing.assert_array_equal(left, right * (1, 1, -1))
    np.testing.assert_array_equal(left[[0, -1]], right[[0, -1]])
    assert (right[1:-1, :, 2] > 0).all()
    body = slice(1, V - 8)  # the surface is level at either ridge
    for ridge, beside in ((0, 1), (-1, -2)):
        rise = np.abs(right[beside, body, 1] - right[ridge, body, 1])
        assert (rise < 0.02 * (right[beside, body, 2])).all()


def test_the_surface_meets_the_outline_of_body_tail_and_fins(plan):
    points = rest_control_points(plan, LENGTH, SNOUT)
    body = drawn(points, RIGHT, (U, V))
    behind = (SNOUT - body[..., 0]) / LENGTH
    for ridge, curve in ((0, plan.back), (-1, plan.belly)):
        expected = LENGTH * along(curve, behind[ridge])
        np.testing.assert_allclose(body[ridge, :, 1], expected, atol=0.012 * LENGTH)
    span = plan.wing.span if plan.wing else max(width for _, width in plan.width)
    assert body[..., 2].max() == pytest.approx(LENGTH * span, rel=0.03)
    assert body[..., 0].max() == pytest.approx(SNOUT, abs=1e-9)
    far = max(distance for _, distance in plan.tail.edge)
    assert body[..., 0].min() == pytest.approx(SNOUT - far * LENGTH, abs=0.01 * LENGTH)
    edge = body[:, -1]  # of the tail: flat, and forked as planned
    assert np.abs(edge[:, 2]).max() < 0.003 * LENGTH
    behind = (SNOUT - edge[[0, len(edge) // 2, -1], 0]) / LENGTH
    np.testing.assert_allclose(behind, plan.tail.edge_at(np.array([1.0, 0.0, -1.0])), atol=0.02)
    for patch, fin, curve, side in (
        (DORSAL, plan.dorsal, plan.back, 1),
        (VENTRAL, plan.ventral, plan.belly, -1),
    ):
        rows = drawn(points, patch, (FIN_U, FIN_V), (2, 101))
        assert (rows[..., 2] == 0).all()
        if fin is None:
            assert np.ptp(rows, axis=(0, 1)).max() < 1e-12  # no area: nothing is drawn
            continue
        base = along(curve, (SNOUT - rows[0, :, 0]) / LENGTH) * LENGTH
        assert (side * (base - rows[0, :, 1]) > 0).all()  # sunk
        highest = max(side * height for _, height in fin.edge)
        assert (side * rows[1, :, 1]).max() == pytest.approx(highest * LENGTH, rel=0.03)


def test_a_tail_may_have_a_longer_upper_lobe():
    plan = load_species("fusilier").surface
    tail = structs.replace(plan.tail, edge=[(-1.0, 0.92), (-0.2, 0.88), (1.0, 1.0)])
    belly = [point for point in plan.belly if point[0] < 0.9] + [(0.92, -0.11)]
    plan = structs.replace(plan, tail=tail, belly=belly)
    edge = drawn(rest_control_points(plan, 1.0, 0.0), RIGHT, (U, V))[:, -1]
    np.testing.assert_allclose(edge[0, :2], (-1.0, 0.142), atol=1e-6)
    np.testing.assert_allclose(edge[-1, :2], (-0.92, -0.11), atol=1e-6)


def test_a_curve_meets_its_points_and_never_overshoots():
    curve = np.array([[0.0, 0.0], [0.1, 1.0], [0.3, 1.2], [0.7, 1.2], [1.0, -0.5]])
    np.testing.assert_allclose(along(curve, curve[:, 0]), curve[:, 1], atol=1e-12)
    fine = along(curve, np.linspace(-0.2, 1.2, 2001))
    assert fine.max() <= 1.2 + 1e-12
    assert fine.min() >= -0.5 - 1e-12
    slope = np.diff(along(curve, np.linspace(0, 1, 20001))) * 20000
    assert np.abs(np.diff(slope)).max() < 0.1  # C1


@pytest.fixture
def ray():
    return load_species("spotted_eagle_ray").surface


def test_a_wing_meets_its_outline_and_is_thin_there(ray):
    half = drawn(rest_control_points(ray, 1.0, 0.0), RIGHT, (U, V), (33, 241))
    edge = half[16, : int(241 * 12.5 / 19)]
    corners = np.array(ray.wing.outline)
    fine = np.concatenate([np.linspace(a, b, 40) for a, b in pairwise(corners)])
    apart = np.linalg.norm((edge[:, [0, 2]] * (-1, 1))[:, None] - fine, axis=2)
    assert apart.min(axis=1).max() < 0.008
    wing = fine[:, 0] < 0.26  # behind it the edge runs out into the tail
    assert apart.min(axis=0)[wing].max() < 0.008
    assert half[..., 2].max() == pytest.approx(ray.wing.span, abs=0.008)
    assert np.abs(edge[:, 1]).max() < 0.002
    thickness = half[:17, :, 1] - half[:15:-1, :, 1]
    assert thickness.min() > -1e-4  # the upper side lies above the lower one
    # Seen from above no cell of the upper side is folded.
    top = drawn(rest_control_points(ray, 1.0, 0.0), RIGHT, (U, V), (17, 121))[:9, :80][..., [0, 2]]
    u, v = np.diff(top, axis=0)[:, :-1], np.diff(top, axis=1)[:-1]
    assert (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0] > -1e-9).all()


def test_absurd_wings_and_tails_are_refused(ray):
    wing, tail = msgspec.to_builtins(ray.wing), {"begin": 0.8}
    blunt = [(0.0, 0.3), (0.1, 0.2), (0.2, 0.1), (0.3, 0.05), (0.4, 0.0)]
    twice = [(0.0, 0.0), (0.1, 0.2), (0.1, 0.2), (0.2, 0.1), (0.3, 0.0)]
    for kind, table, words in (
        (WingPlan, wing | {"outline": blunt}, "tip"),
        (WingPlan, wing | {"outline": twice}, "outline"),
        (WingPlan, wing | {"thickness": [(0.5, 1.0), (0.2, 0.1)]}, "thickness"),
        (TailPlan, tail | {"edge": [(0.2, 0.9), (1.0, 1.0)]}, "from 0 or -1 to 1"),
        (TailPlan, tail | {"edge": [(-1.0, 0.9), (0.5, 1.0)]}, "from 0 or -1 to 1"),
        (TailPlan, tail | {"edge": [(-0.5, 0.9), (1.0, 1.0)]}, "from 0 or -1 to 1"),
    ):
        with pytest.raises(msgspec.ValidationError, match=words):
            msgspec.convert(table, kind)
