import numpy as np
import pytest

from subsea.biomechanics.body import build_body
from subsea.biomechanics.fins import EDGE_ON, STEEPEST, balance, couple_force, pectoral_force
from subsea.biomechanics.simulation import at_rest
from subsea.geometry.rotation import about, matrix

STILL = np.zeros(3)
SPEED = 1.5


@pytest.fixture
def under_way(fusilier):
    state = at_rest(build_body(fusilier.body))
    state.v[:] = (SPEED, 0.0, 0.0)
    return state


@pytest.mark.parametrize("angle", [np.pi / 4, 1.2, EDGE_ON, 2.0, 3 * np.pi / 4, np.pi])
def test_the_force_is_that_of_equation_4_16(under_way, angle):
    force = pectoral_force(under_way, 3.0, angle, angle, STILL).sum(axis=0)
    normal = np.array([np.cos(angle), np.sin(angle), 0.0])
    np.testing.assert_allclose(force, -2 * 3.0 * SPEED**2 * np.cos(angle) * normal, atol=1e-12)


def test_raised_edges_lift_lowered_ones_sink_and_flat_ones_brake(under_way):
    def total(angle):
        return float(pectoral_force(under_way, 3.0, angle, angle, STILL)[:, 1].sum())

    assert total(EDGE_ON + 0.3) > 0 > total(EDGE_ON - 0.3)
    brake = pectoral_force(under_way, 3.0, np.pi, np.pi, STILL)
    assert brake[:, 0].sum() == pytest.approx(-6 * SPEED**2)
    assert abs(brake[:, 1]).max() < 1e-12


def test_each_fin_pushes_the_midsection_of_its_own_side(under_way):
    force = pectoral_force(under_way, 3.0, np.pi, EDGE_ON, STILL)
    pushed = np.flatnonzero(np.abs(force).max(axis=1) > 1e-9)
    assert pushed.tolist() == [1, 4, 5, 8, 9, 12]
    assert (under_way.x[pushed, 2] < 0).all()
    np.testing.assert_allclose(force[pushed], force[pushed[:1]].repeat(6, axis=0))


def test_a_fish_carried_by_the_water_feels_no_fins(under_way):
    force = pectoral_force(under_way, 3.0, np.pi, 2.0, np.array([SPEED, 0.0, 0.0]))
    np.testing.assert_allclose(force, 0, atol=1e-12)


def test_an_upright_fish_holds_its_fins_edge_on(under_way):
    assert balance(under_way) == pytest.approx((EDGE_ON, EDGE_ON))


def test_fins_work_against_roll_and_pitch_and_never_beyond_their_reach(under_way):
    rest = under_way.x.copy()
    for lean in (0.1, 1.0):
        # Turned about the forward axis the right side goes up for a negative angle.
        under_way.x[:] = rest @ matrix(about(1.0, 0.0, 0.0, -lean)).T
        left, right = balance(under_way)
        assert left - EDGE_ON == pytest.approx(EDGE_ON - right)
        assert 0 < left - EDGE_ON <= STEEPEST
        under_way.x[:] = rest @ matrix(about(0.0, 0.0, 1.0, lean)).T  # nose up
        left, right = balance(under_way)
        assert left == pytest.approx(right)
        assert -STEEPEST <= left - EDGE_ON < 0


def test_a_couple_turns_without_pushing():
    rng = np.random.default_rng(0)
    x, inertia = rng.normal(size=(23, 3)), rng.uniform(1, 5, 23)
    force = couple_force(x, inertia, (0.0, 1.0, 0.0), 0.3)
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-12)
    arm = x - inertia @ x / inertia.sum()
    moment = (inertia * (arm[:, 0] ** 2 + arm[:, 2] ** 2)).sum()
    assert np.cross(arm, force).sum(axis=0)[1] == pytest.approx(0.3 * moment)
