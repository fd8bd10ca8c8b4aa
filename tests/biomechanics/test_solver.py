import timeit

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh, solveh_banded

from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import (
    HALF_BANDWIDTH,
    LOWER_TAIL,
    MUSCLES,
    NODES,
    UNITS,
    UPPER_TAIL,
    build_body,
)
from subsea.biomechanics.reactive_water import ALL_KEPT, NO_SECTIONS
from subsea.biomechanics.simulation import at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import (
    STEP,
    Chain,
    advance,
    assemble,
    check_step,
    factorize,
    longest_step,
    substitute,
)
from subsea.fish.species import Species, load_species, muscular_names

ROWS = NODES + HALF_BANDWIDTH  # of the padded band
FIXED_UNITS = UNITS.view()  # as a kernel sees a constant
FIXED_UNITS.flags.writeable = False


def to_band(matrix):
    band = np.zeros((ROWS, HALF_BANDWIDTH + 1))
    for k in range(HALF_BANDWIDTH + 1):
        band[: NODES - k, k] = np.diagonal(matrix, k)
    return band


def from_band(band):
    matrix = np.diag(band[:NODES, 0])
    for k in range(1, HALF_BANDWIDTH + 1):
        matrix += np.diag(band[: NODES - k, k], k) + np.diag(band[: NODES - k, k], -k)
    return matrix


def padded(load):
    return np.concatenate([load, np.zeros((ROWS - NODES, 3))])


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1e3))
def test_the_factorised_solution_is_that_of_a_dense_solver(seed, stiffness):
    random = np.random.default_rng(seed)
    matrix = np.diag(random.uniform(1, 200, NODES))
    for i, j in UNITS:
        eta = stiffness * random.uniform(0, 1)
        matrix[[i, j], [i, j]] += eta
        matrix[[i, j], [j, i]] -= eta
    load = random.normal(0, 100, (NODES, 3))
    band, solution = to_band(matrix), padded(load)
    assert factorize(band, np.empty(HALF_BANDWIDTH + 1)) > 0
    substitute(band, solution)
    np.testing.assert_allclose(
        solution[:NODES], np.linalg.solve(matrix, load), rtol=1e-9, atol=1e-9
    )


def test_the_smallest_pivot_tells_an_indefinite_matrix():
    matrix = np.eye(NODES)
    matrix[3, 3] = -1.0
    assert factorize(to_band(matrix), np.empty(HALF_BANDWIDTH + 1)) <= 0


def assembled(body, x, v):
    band, load, strain = to_band(np.zeros((23, 23))), np.zeros((ROWS, 3)), np.array([np.inf, 0.0])
    muscle = body.length[:MUSCLES] * 0.9
    assemble(x, v, Chain(body.material, FIXED_UNITS, ALL_KEPT), muscle, STEP, band, load, strain)
    return from_band(band), load[:NODES], strain


def test_forces_and_matrix_are_those_of_voigt_units(species):
    body = build_body(species.body)
    random = np.random.default_rng(5)
    x, v = body.rest + random.normal(0, 0.05, (23, 3)), random.normal(0, 1, (23, 3))
    matrix, load, strain = assembled(body, x, v)
    rest = np.concatenate([body.length[:MUSCLES] * 0.9, body.length[MUSCLES:]])
    force, expected = np.zeros((23, 3)), np.diag(body.mass / STEP)
    for s, (i, j) in enumerate(UNITS):
        r = x[j] - x[i]
        distance = np.linalg.norm(r)
        rate = (v[j] - v[i]) @ r / distance
        pull = body.stiffness[s] * (distance - rest[s]) + body.viscosity[s] * rate
        force[i] += pull * r / distance
        force[j] -= pull * r / distance
        eta = max(0.0, pull / distance) * STEP
        expected[[i, j], [i, j]] += eta
        expected[[i, j], [j, i]] -= eta
    np.testing.assert_allclose(load, force + body.mass[:, None] / STEP * v, atol=1e-9)
    np.testing.assert_allclose(matrix, expected, atol=1e-9)
    ratios = np.linalg.norm(x[UNITS[:, 1]] - x[UNITS[:, 0]], axis=1) / body.length
    np.testing.assert_allclose(strain, [ratios.min(), ratios.max()])


def test_a_squeezed_body_keeps_its_matrix_definite(species):
    body = build_body(species.body)
    matrix = assembled(body, 0.7 * body.rest, np.zeros((23, 3)))[0]
    assert np.linalg.eigvalsh(matrix).min() > 0


def in_vacuum(species):
    return build_body(species.body)._replace(drag=0.0, sections=NO_SECTIONS)


def test_momentum_is_kept_in_a_vacuum(species):
    body = in_vacuum(species)
    state = at_rest(body)
    state.v[:] = np.random.default_rng(3).normal(0, 0.5, (23, 3))
    before = body.mass @ state.v
    simulate(body, state, np.zeros((600, MUSCLES)))
    np.testing.assert_allclose(body.mass @ state.v, before, rtol=1e-11)


def test_a_free_vibration_has_the_frequency_of_its_eigenmode(fusilier):
    """A small swing in the softest mode follows cos(ωt) exp(-δt) of the linear theory."""
    body = in_vacuum(fusilier)
    stiffness = np.zeros((NODES, 3, NODES, 3))
    for (i, j), c in zip(UNITS, body.stiffness, strict=True):
        along = body.rest[j] - body.rest[i]
        block = c * np.outer(along, along) / (along @ along)
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            stiffness[a, :, b] += sign * block
    mass = np.diag(np.repeat(body.mass, 3))
    squared, modes = eigh(stiffness.reshape(69, 69), mass)
    omega, mode = np.sqrt(squared[6]), modes[:, 6].reshape(23, 3)
    damping = mode.ravel() @ stiffness.reshape(69, 69) @ mode.ravel()
    # Every unit has the viscosity κ; as the units' c differ little, κ/c·K is close enough.
    delta = 0.5 * damping * body.viscosity[0] / body.stiffness.mean()
    state = at_rest(body)
    state.x[:] += 1e-4 * mode
    step, ticks = 0.002, 800
    frames = simulate(body, state, np.zeros((6 * ticks, MUSCLES)), step=step)
    swing = np.einsum("tij,ij,i->t", frames - body.rest, mode, body.mass) / 1e-4
    time = 6 * step * np.arange(1, ticks + 1)
    np.testing.assert_allclose(swing, np.cos(omega * time) * np.exp(-delta * time), atol=0.05)


def with_one_unit(unit, viscosity=0.0):
    """A body in a vacuum with only one viscoelastic unit left: two nodes on a spring."""
    body = in_vacuum(load_toml(resource_path("docs/tu_fusilier.toml"), Species))
    only = np.arange(len(UNITS)) == unit
    return body._replace(stiffness=only * 30.0, viscosity=only * viscosity)


@pytest.mark.parametrize(("unit", "viscosity"), [(0, 0.0), (30, 0.6), (90, 1.5)])
def test_two_nodes_on_a_unit_are_a_damped_oscillator(unit, viscosity):
    body, (i, j) = with_one_unit(unit, viscosity), UNITS[unit]
    reduced = body.mass[i] * body.mass[j] / (body.mass[i] + body.mass[j])
    omega, delta = np.sqrt(30.0 / reduced), viscosity / (2 * reduced)
    swing = np.sqrt(omega**2 - delta**2)
    along = (body.rest[j] - body.rest[i]) / body.length[unit]
    state, pull = at_rest(body), 0.05 * body.length[unit]
    state.x[j] += pull * along
    step, ticks = 2e-4, 3000
    frames = simulate(body, state, np.zeros((6 * ticks, MUSCLES)), step=step)
    stretch = np.linalg.norm(frames[:, j] - frames[:, i], axis=1) - body.length[unit]
    time = 6 * step * np.arange(1, ticks + 1)
    assert swing * time[-1] > 2 * np.pi  # at least a whole period
    expected = np.exp(-delta * time) * (np.cos(swing * time) + delta / swing * np.sin(swing * time))
    np.testing.assert_allclose(stretch / pull, expected, atol=0.02)


def test_two_nodes_keep_their_energy_and_turn_about_their_centre():
    """Energy of stretching, swinging and spinning; momentum and spin by their closed forms."""
    body, (i, j) = with_one_unit(40), UNITS[40]
    state = at_rest(body)
    state.v[i], state.v[j] = (0.3, -0.2, 0.5), (-0.1, 0.4, 0.2)

    def of(state):
        two = [i, j]
        stretch = np.linalg.norm(state.x[j] - state.x[i]) - body.length[40]
        energy = 0.5 * body.mass[two] @ (state.v[two] ** 2).sum(axis=1) + 15.0 * stretch**2
        spin = np.cross(state.x[two], body.mass[two, None] * state.v[two]).sum(axis=0)
        return float(energy), body.mass[two] @ state.v[two], spin

    before = of(state)
    simulate(body, state, np.zeros((60_000, MUSCLES)), step=1e-4)
    after = of(state)
    for one, other, allowed in zip(before, after, (5e-3, 1e-11, 5e-3), strict=True):
        np.testing.assert_allclose(other, one, rtol=allowed, atol=allowed)


def test_a_step_costs_less_than_two_fifths_of_a_banded_lapack_solve(fusilier):
    """Forces, assembly, factors and three right-hand sides, beside the solve alone."""
    body = build_body(fusilier.body)
    state = at_rest(body)
    state.v[:] = np.random.default_rng(2).normal(0, 0.3, (NODES, 3))
    muscles = np.tile(body.length[:MUSCLES], (100, 1))
    band, load = np.zeros((ROWS, HALF_BANDWIDTH + 1)), np.zeros((ROWS, 3))
    strain = np.array([np.inf, 0.0])
    chain = Chain(body.material, FIXED_UNITS, ALL_KEPT)
    assemble(state.x, state.v, chain, muscles[0], STEP, band, load, strain)
    lower, right = np.ascontiguousarray(band[:NODES].T), load[:NODES].copy()
    still, none = np.zeros(3), np.zeros((NODES, 3))

    def fastest(work):
        return min(timeit.repeat(work, number=1, repeat=60))

    def steps():
        x, v, watch = copy_state(state)
        advance(x, v, body.material, muscles, still, none, STEP, watch)

    def solves():
        for _ in range(100):
            solveh_banded(lower, right, lower=True, check_finite=False)

    assert fastest(steps) <= 0.4 * fastest(solves)


def contractions():
    return np.random.default_rng(7).uniform(0, 0.2, (1, MUSCLES)) * np.ones((240, 1))


def turn_about(axis, angle):
    turn = np.eye(3)
    a, b = [k for k in range(3) if k != axis]
    turn[[a, b], [a, b]] = np.cos(angle)
    turn[a, b], turn[b, a] = -np.sin(angle), np.sin(angle)
    return turn


def test_a_body_that_starts_at_another_attitude_moves_the_same(species):
    body = build_body(species.body)
    turn = turn_about(0, 0.4) @ turn_about(1, -1.1) @ turn_about(2, 2.0)
    one = at_rest(body)
    one.v[:] = (1.0, 0.1, 0.2)
    other = copy_state(one)
    other.x[:], other.v[:] = one.x @ turn.T + (3, 4, 5), one.v @ turn.T
    np.testing.assert_allclose(
        simulate(body, other, contractions()),
        simulate(body, one, contractions()) @ turn.T + (3, 4, 5),
        atol=1e-8,
    )


def test_a_fish_adrift_in_a_current_moves_as_in_still_water(species):
    body = build_body(species.body)
    current = np.array([0.4, -0.2, 0.9])
    still, adrift = at_rest(body), at_rest(body)
    adrift.v[:] = current
    frames = simulate(body, still, contractions())
    carried = simulate(body, adrift, contractions(), water=current)
    time = STEP * 6 * np.arange(1, len(frames) + 1)
    np.testing.assert_allclose(carried - time[:, None, None] * current, frames, atol=1e-8)


def test_a_current_carries_a_limp_body_along(fusilier):
    body = build_body(fusilier.body)
    state = at_rest(body)
    current = np.array([0.0, 0.0, 1.0])
    speeds = []
    for _ in range(10):
        simulate(body, state, np.zeros((180, MUSCLES)), water=current)
        speeds.append(float(body.mass @ state.v[:, 2] / body.mass.sum()))
    assert (np.diff(speeds) > 0).all()
    assert 0.8 < speeds[-1] < 1.0


def test_runs_repeat_to_the_last_bit():
    body = build_body(load_species("fusilier").body)

    def run():
        state = at_rest(body)
        simulate(body, state, contractions())
        return state

    one, other = run(), run()
    assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("name", ["tu", *muscular_names()])
def test_a_kicked_body_settles_below_the_limit_and_bursts_above(name, fusilier):
    """Water holds a growing mode down above the limit, that of slender bodies for long."""
    plan = fusilier.body if name == "tu" else load_species(name).body
    assert plan
    body = build_body(plan)
    limit = longest_step(body)[0]

    def sound(step):
        state = at_rest(body)
        state.v[:] = np.random.default_rng(1).normal(0, 0.2, (23, 3))
        simulate(body, state, np.zeros((1200, MUSCLES)), step=step)
        return is_sound(state)

    assert sound(0.97 * limit)
    assert not sound((1.12 if name == "tu" else 1.6) * limit)


def test_the_limit_of_two_masses_on_a_spring(fusilier):
    """All units but one without stiffness or damping: ω² = 2 k/m, and h² ω² + 2 h (2 c/m) = 4."""
    body = build_body(fusilier.body)
    body.mass[:] = 3.0
    body.stiffness[1:] = 0.0
    body.viscosity[1:] = 0.0
    k, c = 2 * body.stiffness[0] / 3.0, 2 * body.viscosity[0] / 3.0
    step = longest_step(body)[0]
    assert step**2 * k + 2 * step * c == pytest.approx(4.0)


def test_the_node_that_limits_is_the_light_one(fusilier):
    body = build_body(fusilier.body)
    assert longest_step(body)[1] in (UPPER_TAIL, LOWER_TAIL)
    body.mass[7] = 0.01
    assert longest_step(body)[1] == 7


def test_the_check_agrees_with_the_limit(species):
    assert longest_step(build_body(species.body))[0] > STEP
    check_step(species.body)
