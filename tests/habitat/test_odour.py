"""Odours in the water: conserved, carried, spread, lost at the edge, stopped by stone."""

import numpy as np
import pytest

from subsea.habitat.odour import (
    LIFE_S,
    SPREAD_CM2_S,
    carry_odours,
    make_odour,
    outflow,
    release,
    release_catches,
)
from subsea.perception.smell import strength
from subsea.state import ALARM, BAIT_ODOUR, BLOOD

STILL = np.zeros(3)
STEP_S = 0.264
WALL = [(0.0, y, -300.0, 160.0, 90.0, 500.0, 0.0) for y in range(-1500, 1501, 60)]


@pytest.fixture
def waters(tank):
    """A sea 20 m wide and 6 m deep with solids, and its odours."""

    def make(radius=1000.0, **solids):
        sea = tank(1, **solids).sea._replace(radius=radius)
        return sea, make_odour(sea)

    return make


def carry(odour, seconds, flow, radius=1000.0):
    for _ in range(round(seconds / STEP_S)):
        carry_odours(odour, radius, np.asarray(flow, float), STEP_S)


def mass(odour, channel):
    return float(odour.amount[channel].sum(dtype=np.float64)) * odour.cell_cm**3 * 1e-6


def middle(odour, channel):
    """Mean place and standard deviations (3,) of an odour, cm."""
    amount = odour.amount[channel].astype(float)
    axes = np.meshgrid(*(np.arange(n) + 0.5 for n in amount.shape), indexing="ij")
    places = np.stack(axes[::-1], -1) * odour.cell_cm + odour.corner
    share = (amount / amount.sum())[..., None]
    mean = (share * places).sum((0, 1, 2))
    return mean, np.sqrt((share * (places - mean) ** 2).sum((0, 1, 2)))


@pytest.mark.parametrize("rocks", [[], [(0.0, 150.0, -300.0, 150.0, 100.0, 200.0, 0.4)]])
def test_mass_only_decays(waters, rocks):
    _, odour = waters(rocks=rocks)
    release(odour, BLOOD, 2.0, (-300.0, 0.0, -300.0))
    assert mass(odour, BLOOD) == pytest.approx(2.0)
    carry(odour, 30.0, (6.0, 2.0, 0.0))
    left = 2.0 * np.exp(-round(30.0 / STEP_S) * STEP_S / LIFE_S[BLOOD])
    assert mass(odour, BLOOD) == pytest.approx(left, rel=1e-3)
    assert odour.total[BLOOD] == pytest.approx(mass(odour, BLOOD), rel=1e-4)
    assert (odour.amount >= 0.0).all()
    assert (odour.amount[:, ~odour.water] == 0.0).all()
    assert mass(odour, BAIT_ODOUR) == mass(odour, ALARM) == 0.0


def test_a_cloud_moves_and_spreads_as_in_closed_form(waters):
    """Its middle moves by u t, and its variance along y grows by 2 K t."""
    _, odour = waters(radius=1500.0)
    _, ny, nx = odour.water.shape
    y, x = np.mgrid[:ny, :nx] * odour.cell_cm + odour.corner[0] + 0.5 * odour.cell_cm
    odour.amount[BLOOD] = np.exp(-((x + 500.0) ** 2 + y**2) / (2.0 * 200.0**2))
    odour.total[BLOOD] = mass(odour, BLOOD)
    before, was = middle(odour, BLOOD)
    carry(odour, 60.0, (10.0, 0.0, 0.0), 1500.0)
    after, wide = middle(odour, BLOOD)
    assert after - before == pytest.approx([600.0, 0.0, 0.0], abs=6.0)
    expected = was[1] ** 2 + 2.0 * SPREAD_CM2_S[1] * 60.0
    assert wide[1] ** 2 == pytest.approx(expected, rel=0.05)
    # The limiter keeps the front sharp: plain upwind would spread by u h t = 75,000 cm² more.
    expected = was[0] ** 2 + 2.0 * SPREAD_CM2_S[0] * 60.0
    assert wide[0] ** 2 == pytest.approx(expected, abs=15_000.0)


def test_an_even_odour_stays_even_around_a_stone(waters):
    """The flow around solids has no divergence, so it gathers nothing."""
    _, odour = waters(rocks=[(0.0, 0.0, -300.0, 200.0, 150.0, 250.0, 0.3)])
    nz, ny, nx = odour.water.shape
    inner = [
        outflow(odour.flux[way], k, j, i)
        for way in range(2)
        for k in range(nz)
        for j in range(1, ny - 1)
        for i in range(1, nx - 1)
        if odour.water[k, j, i]
    ]
    assert (~odour.water).any()
    assert np.abs(inner).max() < 2e-3
    aside = odour.flux[0, 0, nz // 2, :, nx // 2]
    assert aside.max() > 1.05  # the water is faster beside the stone ...
    assert aside[2] == pytest.approx(1.0, abs=0.1)  # ... and as before far from it


def test_stone_stops_odour(waters):
    """A wall across the sea, from the seabed to the surface, lets nothing through."""
    _, odour = waters(rocks=WALL)
    release(odour, BLOOD, 1.0, (-400.0, 0.0, -300.0))
    carry(odour, 90.0, (5.0, 0.0, 0.0))
    east = odour.corner[0] + (np.arange(odour.water.shape[2]) + 0.5) * odour.cell_cm > 0.0
    assert odour.amount[BLOOD][:, :, east].max() == 0.0
    assert mass(odour, BLOOD) > 0.3
    _, free = waters()
    release(free, BLOOD, 1.0, (-400.0, 0.0, -300.0))
    carry(free, 90.0, (5.0, 0.0, 0.0))
    assert free.amount[BLOOD][:, :, east].max() > 0.01


def test_what_leaves_the_sea_is_lost_and_little_is_forgotten(waters):
    _, odour = waters()
    release(odour, BLOOD, 1.0, (800.0, 0.0, -300.0))
    carry(odour, 120.0, (10.0, 0.0, 0.0))
    assert odour.total[BLOOD] == 0.0
    assert not odour.amount.any()


def test_a_catch_releases_blood_and_alarm_in_water(waters):
    """In a cell of stone it enters the nearest one of water."""
    _, odour = waters(rocks=[(0.0, 0.0, -300.0, 70.0, 70.0, 70.0, 0.0)])
    release_catches(odour, np.array([[0.0, 0.0, -300.0]], np.float32))
    assert odour.total.tolist() == [0.0, 1.0, 1.0]
    assert (odour.amount[:, ~odour.water] == 0.0).all()
    assert strength(odour, odour.amount[BLOOD], (0.0, 0.0, -300.0)) > 0.0
