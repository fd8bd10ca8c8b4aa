"""Plankton: it drifts with the water, past what stands there, is eaten and comes again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.vector import vector
from subsea.habitat.contact import clearance
from subsea.habitat.current import REACH_CM, flow_near
from subsea.habitat.plankton import CLEARANCE_CM, RETURN_CM, RETURN_HEIGHT_CM, drift, scatter
from subsea.habitat.rocks import rock_cells
from subsea.state import Clock

DT = 0.033
RADIUS, WIDTH = 500.0, 800.0
FLOOR = np.full((5, 5), -300.0, np.float32)
PILLARS = np.array([(0.0, 0.0, 80.0, -60.0), (60.0, 40.0, 70.0, 50.0), (-470.0, 0.0, 60.0, -10.0)])
ROCKS = np.array([(-200.0, 100.0, -280.0, 90.0, 60.0, 50.0, 0.4)])


def _scattered(number=300, seed=0, pillars=PILLARS[:0], rocks=ROCKS[:0]):
    return scatter(np.random.default_rng(seed), number, RADIUS, FLOOR, WIDTH, pillars, rocks)


def _pass(sea, flow, ticks, seed=0, first=0):
    cells = rock_cells(sea.rocks, REACH_CM)
    for tick in range(first, first + ticks):
        drift(np.arange(len(sea.plankton)), sea, cells, np.array(flow), Clock(seed, tick, DT))


def test_scattered_evenly_in_the_water():
    specks = _scattered(4000)
    inner = (np.hypot(specks[:, 0], specks[:, 1]) < RADIUS / np.sqrt(2)).mean()
    assert abs(inner - 0.5) < 0.04  # half of the area
    assert specks[:, 2].min() >= -300 + CLEARANCE_CM
    assert specks[:, 2].max() <= -CLEARANCE_CM


def test_none_is_scattered_into_a_solid():
    bare, specks = _scattered(2000), _scattered(2000, pillars=PILLARS, rocks=ROCKS)
    assert min(clearance(PILLARS, ROCKS, vector(p)) for p in bare) < -30.0
    assert min(clearance(PILLARS, ROCKS, vector(p)) for p in specks) >= 0.0
    moved = (bare != specks).any(axis=1)
    assert 0.03 < moved.mean() < 0.2  # the others stay where they were


@given(st.floats(-60, 60), st.floats(-60, 60), st.integers(0, 1000))
def test_stays_in_the_sea_whatever_the_current(make_sea, vx, vy, seed):
    sea = make_sea(_scattered(60))
    _pass(sea, (vx, vy, 0.0), 200, seed)
    assert np.hypot(sea.plankton[:, 0], sea.plankton[:, 1]).max() <= RADIUS * 1.01
    assert sea.plankton[:, 2].min() >= -300 + CLEARANCE_CM - 1e-3
    assert sea.plankton[:, 2].max() <= -CLEARANCE_CM + 1e-3


@pytest.mark.nightly
@given(st.floats(-60, 60), st.floats(-60, 60), st.integers(0, 1000))
def test_none_ever_enters_a_pillar_or_a_rock(make_sea, vx, vy, seed):
    sea = make_sea(_scattered(150, seed, PILLARS, ROCKS), PILLARS, ROCKS)
    for tick in range(200):
        sea.absent[tick % 150] = DT  # eaten, and back in the next tick
        _pass(sea, (vx, vy, 0.0), 1, seed, tick)
        assert min(clearance(PILLARS, ROCKS, vector(p)) for p in sea.plankton) > -1e-3


def test_the_crowd_moves_with_the_water(make_sea):
    sea = make_sea(_scattered(2000), radius=1e6)
    before = sea.plankton.copy()
    _pass(sea, (10.0, 0.0, 0.0), 30, seed=1)
    np.testing.assert_allclose((sea.plankton - before).mean(axis=0)[:2], [9.9, 0.0], atol=0.3)


def test_specks_pass_solids_as_if_they_felt_them_in_every_tick(make_sea):
    flow, cells = (14.0, 6.0, 0.0), rock_cells(ROCKS, REACH_CM)
    sea = make_sea(_scattered(600, 0, PILLARS, ROCKS), PILLARS, ROCKS)
    start = sea.plankton.astype(float)
    _pass(sea, flow, 60)
    # Without solids they wander alike.
    bare = make_sea(start)
    _pass(bare, (0.0, 0.0, 0.0), 60)
    wander = (bare.plankton - start) / 60
    places = start.copy()
    for _ in range(60):
        places += wander + [
            np.multiply(DT, flow_near(PILLARS, cells, flow, tuple(place))) for place in places
        ]
    near = np.array([0.0 < clearance(PILLARS, ROCKS, tuple(place)) < 60.0 for place in start])
    inside = (np.hypot(start[:, 0], start[:, 1]) < 450.0) & (np.abs(start[:, 2] + 150.0) < 100.0)
    apart = np.linalg.norm(sea.plankton - places, axis=1)[near & inside]
    straight = np.linalg.norm(start + wander * 60 + np.multiply(60 * DT, flow) - places, axis=1)
    assert len(apart) > 30
    assert np.median(apart) < 1.0 and np.percentile(apart, 90) < 3.0
    assert np.median(straight[near & inside]) > 10.0  # solids matter there


def test_eaten_specks_return_near_their_place_after_a_while(make_sea):
    sea = make_sea(_scattered(1000), radius=1000.0)
    eaten = np.arange(0, 1000, 2)
    sea.absent[eaten] = 1.0  # s
    place = np.array([100.0, 0.0, -200.0], np.float32)
    sea.plankton[eaten] = place
    _pass(sea, (4.0, 3.0, 0.0), 29)
    assert (sea.absent > 0.0).sum() == 500
    assert (sea.plankton[eaten] == place).all()
    _pass(sea, (4.0, 3.0, 0.0), 2, first=29)
    assert (sea.absent == 0.0).all()
    x, y, z = (sea.plankton[eaten] - place).T
    # As many in each quarter of the area, of the height and of the compass: 125, but for chance.
    turn = np.arctan2(y, x) / (2 * np.pi) + 0.5
    low = -300.0 + CLEARANCE_CM - place[2]  # the seabed is near
    height = (z - low) / (RETURN_HEIGHT_CM - low)
    for share in ((x * x + y * y) / RETURN_CM**2, height, turn):
        assert (abs(np.histogram(share, 4, (0, 1))[0] - 125) < 40).all()


def test_it_goes_on_in_the_same_way_from_the_same_seed(make_sea):
    ends = []
    for seed in (7, 7, 8):
        sea = make_sea(_scattered(100, 0, PILLARS, ROCKS), PILLARS, ROCKS)
        sea.absent[::3] = 0.2
        _pass(sea, (4.0, 3.0, 0.0), 60, seed)
        ends.append(sea.plankton.tobytes())
    assert ends[0] == ends[1] != ends[2]


def test_a_speck_drawn_into_a_rock_gets_out_again(make_sea):
    sea = make_sea([ROCKS[0, :3]], rocks=ROCKS)
    _pass(sea, (40.0, 0.0, 0.0), 200)
    assert clearance(PILLARS[:0], ROCKS, vector(sea.plankton[0])) > 0.0


def test_specks_drift_over_growths(make_sea):
    sea = make_sea(_scattered(200))
    grown = sea._replace(floor=sea.heights + np.float32(90.0))
    _pass(grown, (5.0, 0.0, 0.0), 30)
    assert grown.plankton[:, 2].min() >= sea.heights.max() + 90.0 + CLEARANCE_CM - 1e-3
