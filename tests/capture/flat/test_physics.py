"""The water and the integrators of the flat fish."""

import numpy as np
import pytest

from capture.flat.experiments import released
from capture.flat.physics import add_forces, explicit_limit, swim


def moving(body):
    """A state (2, n, 2) that is bent, stretched and in motion."""
    rng = np.random.default_rng(3)
    return np.stack([1.03 * body.rest, rng.normal(0.0, 0.5, body.rest.shape)])


def at_ease(body, steps):
    return np.tile(body.length[:6], (steps, 1))


@pytest.mark.parametrize(("implicit", "step"), [(True, 0.055), (False, 0.002)])
def test_in_a_vacuum_momentum_stays(body, implicit, step):
    start = moving(body)
    frames = swim(body._replace(drag=0.0), start, at_ease(body, 400), step, implicit, 100)
    momentum = np.einsum("n,tnk->tk", body.mass, frames[:, 1])
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (5, 1)), rtol=1e-9)
    assert np.abs(frames[-1, 0] - start[0]).max() > 0.1


def test_water_presses_on_the_edges_that_press_on_it(body):
    limp = body._replace(stiffness=0 * body.stiffness, viscosity=0 * body.viscosity)
    force = np.zeros_like(body.rest)
    add_forces(body.rest, np.tile([0.0, 1.0], (12, 1)), limp, body.length, force)
    left, right = force[1:11:2], force[2:11:2]
    assert (left[:, 1] < 0).all()  # a fish that is moved to the left ...
    assert (right == 0).all()  # ... feels nothing on its right
    # On edges along x that is µ, area and speed multiplied.
    expected = -2.0 * (body.rest[1:11:2, 0][:-1] - body.rest[1:11:2, 0][1:]) * body.height[1:5]
    inner = np.convolve(expected, [0.5, 0.5], "valid")
    np.testing.assert_allclose(left[1:4, 1], inner, rtol=0.02)


def test_water_takes_momentum_away(body):
    start = np.stack([body.rest, np.full_like(body.rest, 1.0)])
    frames = swim(body, start, at_ease(body, 200), 0.055, True, 200)
    speed = np.einsum("n,nk->k", body.mass, frames[-1, 1]) / body.mass.sum()
    # Slender: it is braked across its length far more than along it.
    assert 0.7 < speed[0] < 0.95
    assert 0.0 < speed[1] < 0.4


def test_explicit_euler_explodes_beyond_its_limit_and_implicit_does_not(body):
    below, above, _, far, implicit = (energy for _, energy in released(body, 40.0).values())
    assert 0.1 < below[-1] < 1.0
    assert above[-1] > 2.0 * below[-1]
    assert np.isnan(far[-1])
    # Implicit Euler loses energy with every step, 19 times beyond the limit.
    assert (np.diff(implicit) <= 1e-12).all()
    assert implicit[-1] < 0.05


def test_the_limit_is_that_of_the_stiffest_units(body):
    """Were all units alike it would be their viscosity over stiffness, whatever the masses."""
    alike = body._replace(stiffness=np.full_like(body.stiffness, 60.0))
    assert explicit_limit(alike) == pytest.approx(0.2 / 60.0, rel=1e-6)
    ratio = body.viscosity / body.stiffness
    assert ratio.min() <= explicit_limit(body) <= ratio.max()


def test_small_implicit_and_explicit_steps_agree(body):
    start = moving(body)
    ends = [
        swim(body, start, at_ease(body, 1000), 0.001, implicit, 1000)[-1, 0]
        for implicit in (False, True)
    ]
    moved = np.abs(ends[0] - start[0]).max()
    assert np.abs(ends[0] - ends[1]).max() < 0.02 * moved
