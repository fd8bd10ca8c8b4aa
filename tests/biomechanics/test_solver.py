import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh

from subsea.biomechanics.body import (
    HALF_BANDWIDTH,
    MUSCLES,
    NODES,
    UNITS,
    Body,
    Floats,
    build_body,
)
from subsea.biomechanics.simulation import State, at_rest, copy_state, simulate
from subsea.biomechanics.solver import ROWS, STEP, assemble, factorize, substitute
from subsea.species import Species, load_species


def to_band(matrix: Floats) -> Floats:
    band = np.zeros((ROWS, HALF_BANDWIDTH + 1))
    for k in range(HALF_BANDWIDTH + 1):
        band[: NODES - k, k] = np.diagonal(matrix, k)
    return band


def from_band(band: Floats) -> Floats:
    matrix = np.diag(band[:NODES, 0])
    for k in range(1, HALF_BANDWIDTH + 1):
        matrix += np.diag(band[: NODES - k, k], k) + np.diag(band[: NODES - k, k], -k)
    return matrix


def padded(load: Floats) -> Floats:
    return np.concatenate([load, np.zeros((ROWS - NODES, 3))])


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1e3))
def test_the_factorised_solution_is_that_of_a_dense_solver(seed: int, stiffness: float) -> None:
    random = np.random.default_rng(seed)
    matrix = np.diag(random.uniform(1, 200, NODES))
    for i, j in UNITS:
        eta = stiffness * random.uniform(0, 1)
        matrix[[i, j], [i, j]] += eta
        matrix[[i, j], [j, i]] -= eta
    load = random.normal(0, 100, (NODES, 3))
    band, solution = to_band(matrix), padded(load)
    assert factorize(band) > 0
    substitute(band, solution)
    np.testing.assert_allclose(
        solution[:NODES], np.linalg.solve(matrix, load), rtol=1e-9, atol=1e-9
    )


def test_the_smallest_pivot_tells_an_indefinite_matrix() -> None:
    matrix = np.eye(NODES)
    matrix[3, 3] = -1.0
    assert factorize(to_band(matrix)) <= 0


def assembled(body: Body, x: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
    band, load, strain = to_band(np.zeros((23, 23))), np.zeros((ROWS, 3)), np.array([np.inf, 0.0])
    muscle = body.length[:MUSCLES] * 0.9
    assemble(
        x, v, body.mass, body.length, body.stiffness, body.viscosity, muscle, STEP,
        band, load, strain,
    )  # fmt: skip
    return from_band(band), load[:NODES], strain


def test_forces_and_matrix_are_those_of_voigt_units(species: Species) -> None:
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


def test_a_squeezed_body_keeps_its_matrix_definite(species: Species) -> None:
    body = build_body(species.body)
    matrix = assembled(body, 0.7 * body.rest, np.zeros((23, 3)))[0]
    assert np.linalg.eigvalsh(matrix).min() > 0


def in_vacuum(species: Species) -> Body:
    return build_body(species.body)._replace(drag=0.0)


def test_momentum_is_kept_in_a_vacuum(species: Species) -> None:
    body = in_vacuum(species)
    state = at_rest(body)
    state.v[:] = np.random.default_rng(3).normal(0, 0.5, (23, 3))
    before = body.mass @ state.v
    simulate(body, state, np.zeros((600, MUSCLES)))
    np.testing.assert_allclose(body.mass @ state.v, before, rtol=1e-11)


def test_a_free_vibration_has_the_frequency_of_its_eigenmode(fusilier: Species) -> None:
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


def contractions() -> Floats:
    return np.random.default_rng(7).uniform(0, 0.2, (1, MUSCLES)) * np.ones((240, 1))


def turn_about(axis: int, angle: float) -> Floats:
    turn = np.eye(3)
    a, b = [k for k in range(3) if k != axis]
    turn[[a, b], [a, b]] = np.cos(angle)
    turn[a, b], turn[b, a] = -np.sin(angle), np.sin(angle)
    return turn


def test_a_body_that_starts_at_another_attitude_moves_the_same(species: Species) -> None:
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


def test_a_fish_adrift_in_a_current_moves_as_in_still_water(species: Species) -> None:
    body = build_body(species.body)
    current = np.array([0.4, -0.2, 0.9])
    still, adrift = at_rest(body), at_rest(body)
    adrift.v[:] = current
    frames = simulate(body, still, contractions())
    carried = simulate(body, adrift, contractions(), water=current)
    time = STEP * 6 * np.arange(1, len(frames) + 1)
    np.testing.assert_allclose(carried - time[:, None, None] * current, frames, atol=1e-8)


def test_a_current_carries_a_limp_body_along(fusilier: Species) -> None:
    body = build_body(fusilier.body)
    state = at_rest(body)
    current = np.array([0.0, 0.0, 1.0])
    speeds = []
    for _ in range(10):
        simulate(body, state, np.zeros((180, MUSCLES)), water=current)
        speeds.append(float(body.mass @ state.v[:, 2] / body.mass.sum()))
    assert (np.diff(speeds) > 0).all()
    assert 0.8 < speeds[-1] < 1.0


def test_runs_repeat_to_the_last_bit() -> None:
    body = build_body(load_species("fusilier").body)

    def run() -> State:
        state = at_rest(body)
        simulate(body, state, contractions())
        return state

    one, other = run(), run()
    assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
