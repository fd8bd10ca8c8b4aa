"""Plankton and the current that carries it."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.habitat.current import PERIOD_S, flow_at
from subsea.habitat.plankton import CLEARANCE_CM, drift, scatter
from subsea.state import Clock, Sea

RADIUS, WIDTH = 500.0, 800.0
FLOOR = np.full((5, 5), -300.0, np.float32)


def _scattered(number=300, seed=0):
    return scatter(np.random.default_rng(seed), number, RADIUS, FLOOR, WIDTH)


def _sea(number, radius=RADIUS, width=WIDTH):
    specks = _scattered(number)
    return Sea(
        heights=FLOOR, half_width=width, radius=radius,
        pillars=np.zeros((0, 4)), rocks=np.zeros((0, 7)), climate=np.zeros(4),
        plankton=specks, absent=np.zeros(number, np.float32),
        seaweed=np.zeros((0, 6), np.float32), submarine=np.zeros(6),
    )  # fmt: skip


def test_scattered_evenly_in_the_water():
    specks = _scattered(4000)
    inner = (np.hypot(specks[:, 0], specks[:, 1]) < RADIUS / np.sqrt(2)).mean()
    assert abs(inner - 0.5) < 0.04  # half of the area
    assert specks[:, 2].min() >= -300 + CLEARANCE_CM
    assert specks[:, 2].max() <= -CLEARANCE_CM


@given(st.floats(-60, 60), st.floats(-60, 60), st.integers(0, 1000))
@settings(max_examples=20)
def test_stays_in_the_sea_whatever_the_current(vx, vy, seed):
    sea = _sea(60)
    specks = sea.plankton
    for tick in range(200):
        drift(sea, np.array([vx, vy, 0.0]), Clock(seed, tick, 0.033))
    assert np.hypot(specks[:, 0], specks[:, 1]).max() <= RADIUS * 1.01
    assert specks[:, 2].min() >= -300 + CLEARANCE_CM - 1e-3
    assert specks[:, 2].max() <= -CLEARANCE_CM + 1e-3


def test_the_crowd_moves_with_the_water():
    sea = _sea(2000, 1e6, 2e6)
    specks, before = sea.plankton, sea.plankton.copy()
    for tick in range(30):
        drift(sea, np.array([10.0, 0.0, 0.0]), Clock(1, tick, 0.033))
    np.testing.assert_allclose((specks - before).mean(axis=0)[:2], [9.9, 0.0], atol=0.3)


def test_the_current_swings_about_nothing():
    times = np.linspace(0, PERIOD_S, 1000, endpoint=False)
    flow = np.array([flow_at((3.0, -1.0), t) for t in times])
    np.testing.assert_allclose(flow.mean(axis=0), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.abs(flow).max(axis=0), [3.0, 1.0, 0.0], rtol=1e-4)
