"""A disc of springs in the water: momentum, rest, recovery and posture."""

import numpy as np
import pytest

from subsea.biomechanics.disc import (
    DiscOutline,
    build_disc,
    disc_at_rest,
    flap,
    kept_shape,
    water_momentum,
)
from subsea.biomechanics.solver import STEPS_PER_TICK

ACROSS = np.array([-40.0, -25.0, -12.0, 0.0, 12.0, 25.0, 40.0])
CHORD = np.array([15.0, 30.0, 45.0, 60.0, 45.0, 30.0, 15.0])
OUTLINE = DiscOutline(
    right=ACROSS,
    front=30.0 - 0.5 * CHORD,
    chord=CHORD,
    chords=CHORD * 12.0,
    squares=CHORD**2 * 12.0,
    thick=np.outer(CHORD / 60.0, [6.0, 10.0, 8.0, 4.0]),
    side=np.full(4, 6.0),
    fin=5.0,
    tail=100.0,
)
TICKS = 20


@pytest.fixture(name="disc", scope="module")
def springy_disc():
    return build_disc(OUTLINE, 1e5, 500.0, 1.0, 0.01)


def steps(disc, ticks=TICKS):
    return ticks * STEPS_PER_TICK * disc.substeps


def beating(disc, size=0.1):
    """Contractions of a beat that differs between rows and sides."""
    beat = np.linspace(0.0, 1.0, steps(disc))
    wave = np.sin(2.0 * np.pi * (beat[:, None, None] - 0.1 * np.arange(disc.rows)))
    return size * wave * np.linspace(0.5, 1.0, disc.columns - 1)[:, None]


def test_body_and_water_exchange_all_momentum(disc):
    """Drag and shed water carry away all that both lose; the couples push nothing."""
    state = disc_at_rest(disc, 10.0)

    def total():
        return disc.mass @ state.v + water_momentum(disc, state)

    before = total()
    flap(disc, state, beating(disc), np.full(steps(disc), 0.2))
    assert kept_shape(state)
    assert np.abs(state.lost).max() > 0.01 * np.abs(before).max()
    np.testing.assert_allclose(total() + state.lost, before, atol=1e-9 * np.abs(before).max())


def test_a_still_disc_stays_still(disc):
    state = disc_at_rest(disc)
    relaxed = np.zeros((steps(disc), disc.columns - 1, disc.rows))
    flap(disc, state, relaxed, np.zeros(len(relaxed)))
    np.testing.assert_allclose(state.x, disc.rest, atol=1e-9)
    np.testing.assert_allclose(state.v, 0.0, atol=1e-9)


def test_a_disturbed_disc_comes_back_to_its_shape(disc):
    state = disc_at_rest(disc)
    shift = np.random.default_rng(1).normal(0.0, 0.3, disc.rest.shape)
    state.x[:] += shift
    i, j = disc.units.T

    def strain():
        return abs(np.linalg.norm(state.x[j] - state.x[i], axis=1) / disc.length - 1.0).max()

    disturbed = strain()
    relaxed = np.zeros((steps(disc, 60), disc.columns - 1, disc.rows))
    flap(disc, state, relaxed, np.zeros(len(relaxed)))
    assert strain() < 0.05 * disturbed


def test_fins_bring_a_tilted_disc_back_to_level(disc):
    state = disc_at_rest(disc, 10.0)
    for a, b in ((0, 1), (1, 2)):
        turn = np.eye(3)
        turn[[a, b], [a, b]], turn[a, b], turn[b, a] = np.cos(0.1), -np.sin(0.1), np.sin(0.1)
        state.x[:] = state.x @ turn.T
    relaxed = np.zeros((steps(disc, 120), disc.columns - 1, disc.rows))
    flap(disc, state, relaxed, np.zeros(len(relaxed)))
    middle = disc.mass @ state.x / disc.mass.sum()
    slope = np.linalg.lstsq((state.x - middle)[:, ::2], (state.x - middle)[:, 1], rcond=None)[0]
    assert np.abs(slope).max() < 0.02


def test_strong_muscles_tear_it(disc):
    state = disc_at_rest(disc)
    flap(disc, state, beating(disc, 0.6), np.zeros(steps(disc)))
    assert not kept_shape(state)
