import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.biomechanics.body import TRIANGLE_WEIGHTS, TRIANGLES, build_body
from subsea.biomechanics.manoeuvres import MIRROR
from subsea.biomechanics.simulation import at_rest, simulate
from subsea.biomechanics.water import add_water_force
from subsea.fish.species import load_species


def force_on(x, v, water, drag=1.0):
    force = np.zeros((23, 3))
    add_water_force(x, v, water, drag, force)
    return force


def oracle(x, v, water, drag):
    force = np.zeros((23, 3))
    for corners, weight in zip(TRIANGLES, TRIANGLE_WEIGHTS, strict=True):
        a, b, c = x[corners]
        twice = np.cross(b - a, c - a)
        area, normal = np.linalg.norm(twice) / 2, twice / np.linalg.norm(twice)
        u = v[corners].mean(axis=0) - water
        if normal @ u > 0:
            force[corners] -= weight * drag * area * np.linalg.norm(u) * (normal @ u) * normal / 3
    return force


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 3))
def test_the_kernel_is_equation_4_3_triangle_by_triangle(seed, drag):
    random = np.random.default_rng(seed)
    body = build_body(load_species("fusilier").body)
    x = body.rest + random.normal(0, 0.1, (23, 3))
    v, water = random.normal(0, 2, (23, 3)), random.normal(0, 1, 3)
    np.testing.assert_allclose(
        force_on(x, v, water, drag), oracle(x, v, water, drag), rtol=1e-10, atol=1e-12
    )


def test_a_plate_broadside_meets_area_times_speed_squared(fusilier):
    x = build_body(fusilier.body).rest * [1, 1, 1e-4]
    outline = np.concatenate([x[[0, 1, 5, 9, 13, 17, 21]], x[[22, 20, 16, 12, 8, 4]]])[:, :2]
    p, q = outline, np.roll(outline, -1, axis=0)
    area = abs(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])) / 2
    speed = 1.7
    force = force_on(x, np.tile([0, 0, speed], (23, 1)), np.zeros(3), drag=0.8)
    np.testing.assert_allclose(
        force.sum(axis=0), [0, 0, -0.8 * area * speed**2], rtol=1e-6, atol=1e-3
    )


def test_a_plate_under_a_steady_force_reaches_its_terminal_velocity(fusilier):
    """Broadside, v(t) = u tanh(F t / m u) with u = √(F / µA)."""
    thin = build_body(msgspec.structs.replace(fusilier.body, half_widths=(0.3,) * 5))
    sideways = np.tile([0.0, 0.0, 1.0], (23, 1))
    # Each pair of nodes weighs and is pulled as much as the area it bears: the plate stays flat.
    share = -force_on(thin.rest, sideways, np.zeros(3))[:, 2]
    area = share.sum()
    share = (share + share[MIRROR]) / (2 * area)
    weight, pull = 50.0, 0.5
    plate = thin._replace(mass=weight * share, stiffness=np.full(len(thin.stiffness), 100.0))
    force = pull * share[:, None] * sideways
    state = at_rest(plate)
    terminal = np.sqrt(pull / area)
    step, ticks = 0.01, 80
    for seconds in range(1, 8):
        simulate(plate, state, np.zeros((6 * ticks, 12)), force=force, step=step)
        time = 6 * ticks * step * seconds
        speed = terminal * np.tanh(pull * time / (weight * terminal))
        assert plate.mass @ state.v[:, 2] / weight == pytest.approx(speed, rel=0.02)
    assert speed > 0.9 * terminal
    np.testing.assert_allclose(state.x[:, :2], plate.rest[:, :2], atol=0.1)


def test_doubling_the_speed_quadruples_the_force(species):
    x = build_body(species.body).rest
    v = np.random.default_rng(1).normal(0, 1, (23, 3))
    still = np.zeros(3)
    np.testing.assert_allclose(force_on(x, 2 * v, still), 4 * force_on(x, v, still))


def test_water_only_takes_energy_from_a_body(species):
    x = build_body(species.body).rest
    for seed in range(20):
        v = np.random.default_rng(seed).normal(0, 1, 3) * np.ones((23, 1))
        assert np.sum(force_on(x, v, np.zeros(3)) * v) < 0


@pytest.mark.parametrize("water", [(0.5, 0.0, 0.0), (0.0, -0.3, 1.2)])
def test_only_the_relative_velocity_counts(species, water):
    x = build_body(species.body).rest
    v = np.random.default_rng(2).normal(0, 1, (23, 3))
    moved = force_on(x, v + water, np.array(water))
    np.testing.assert_allclose(moved, force_on(x, v, np.zeros(3)), atol=1e-12)
    assert not force_on(x, np.tile(water, (23, 1)), np.array(water)).any()
