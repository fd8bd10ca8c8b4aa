"""The current and the sources of the solids (Tu §8.1), against the closed form."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.solids import from_pillar, from_rock
from subsea.habitat.current import (
    PERIOD_S,
    SOURCE_CM,
    SPAN,
    add_bow_wave,
    deflection_at,
    flow_at,
    flow_near,
    set_drift,
    shear_at,
)
from subsea.state import Fishes, empty
from tests.support.scenes import everyone
from tests.support.seas import all_rocks

FLOW = (3.0, 1.0, 0.0)
STRENGTH = np.hypot(3.0, 1.0)
PILLAR = np.array([[30.0, -20.0, 50.0, -100.0]])
ROCK = np.array([[10.0, 20.0, -250.0, 80.0, 40.0, 30.0, 0.7]])
NONE, ALONE = all_rocks(np.zeros((0, 7))), all_rocks(ROCK)
NO_PILLARS = np.zeros((0, 4))
ANGLE = st.floats(0.0, 6.28)


def test_the_current_swings_about_nothing():
    times = np.linspace(0, PERIOD_S, 1000, endpoint=False)
    flow = np.array([flow_at((3.0, -1.0), t) for t in times])
    np.testing.assert_allclose(flow.mean(axis=0), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.abs(flow).max(axis=0), [3.0, 1.0, 0.0], rtol=1e-4)


@given(ANGLE, st.floats(1.0, SPAN - 0.01), st.floats(-290.0, -101.0))
def test_beside_a_pillar_flows_the_current_and_its_source(angle, gap, z):
    outward = np.array([np.cos(angle), np.sin(angle), 0.0])
    place = (30.0, -20.0, z) + (50.0 + gap * SOURCE_CM) * outward
    expected = FLOW + STRENGTH / gap**2 * outward
    np.testing.assert_allclose(flow_near(PILLAR, NONE, FLOW, tuple(place)), expected, atol=1e-9)


@given(ANGLE, st.floats(0.0, 400.0), st.floats(-99.0, 0.0))
def test_over_and_far_from_a_pillar_flows_the_current_alone(angle, away, z):
    for r, height in ((away, z), (51.0 + SPAN * SOURCE_CM + away, -200.0)):
        place = (30.0 + r * np.cos(angle), -20.0 + r * np.sin(angle), height)
        assert flow_near(PILLAR, NONE, FLOW, place) == FLOW


@given(ANGLE, ANGLE, st.floats(0.0, 1.0))
def test_none_flows_into_a_pillar_and_nothing_explodes(angle, course, gap):
    flow = (5.0 * np.cos(course), 5.0 * np.sin(course), 0.0)
    reach = 50.0 + gap * SOURCE_CM
    place = (30.0 + reach * np.cos(angle), -20.0 + reach * np.sin(angle), -200.0)
    got = flow_near(PILLAR, NONE, flow, place)
    assert np.dot(got, from_pillar(PILLAR[0], place)[0]) >= -1e-9
    assert np.linalg.norm(got) <= 10.0 + 1e-9


@given(ANGLE, st.floats(80.0, 400.0), st.floats(-290.0, -200.0))
def test_a_rock_is_a_source_too(angle, away, z):
    place = (10.0 + away * np.cos(angle), 20.0 + away * np.sin(angle), z)
    way, gap = from_rock(ROCK[0], place)
    got = np.array(flow_near(NO_PILLARS, ALONE, FLOW, place))
    source = STRENGTH * min((SOURCE_CM / gap) ** 2, 1.0) if 0 < gap < SPAN * SOURCE_CM else 0.0
    if gap > 0:
        np.testing.assert_allclose(got, FLOW + source * np.array([way[0], way[1], 0.0]), atol=1e-9)


def test_at_slack_water_nothing_flows():
    assert flow_near(PILLAR, ALONE, (0.0, 0.0, 0.0), (85.0, -20.0, -200.0)) == (0.0, 0.0, 0.0)


@given(ANGLE, st.floats(0.5, 40.0), ANGLE, st.floats(20.0, 300.0))
def test_solids_deflect_every_current_alike(course, speed, angle, away):
    place = (30.0 + away * np.cos(angle), 20.0 + away * np.sin(angle), -240.0)
    flow = (speed * np.cos(course), speed * np.sin(course), 0.0)
    expected = np.array(flow_near(PILLAR, ALONE, flow, place))
    found = flow + speed * np.array(deflection_at(PILLAR, ALONE, place))
    np.testing.assert_allclose(found, expected, atol=1e-9 * speed)


def test_sources_add_up():
    two = np.concatenate([PILLAR, PILLAR + [200.0, 0.0, 0.0, 0.0]])
    alone = [np.subtract(flow_near(p[None], NONE, FLOW, (130.0, 60.0, -200.0)), FLOW) for p in two]
    both = flow_near(two, NONE, FLOW, (130.0, 60.0, -200.0))
    np.testing.assert_allclose(both, FLOW + alone[0] + alone[1])


def test_every_fish_is_carried_by_the_water_where_it_is(make_sea):
    sea = make_sea(pillars=PILLAR, rocks=ROCK)
    fishes = empty(Fishes, n=200)
    rng = np.random.default_rng(3)
    fishes.position[:] = rng.uniform((-200, -200, -290), (200, 200, 0), (200, 3))
    set_drift(everyone(fishes), fishes, sea, ALONE, np.array(FLOW))
    places = fishes.position.astype(float)
    expected = [flow_near(PILLAR, ALONE, FLOW, tuple(place)) for place in places]
    np.testing.assert_allclose(fishes.drift, expected, rtol=1e-5)
    assert len(np.unique(fishes.drift[:, 0])) > 50


def test_simulated_fishes_feel_what_carries_fishes_at_their_snouts_and_tails(make_sea):
    sea = make_sea(pillars=PILLAR, rocks=ROCK)
    sea.submarine[:6] = -30.0, 60.0, -120.0, 50.0, 0.0, 0.0
    fishes = empty(Fishes, n=50)
    fishes.position[:] = np.random.default_rng(3).uniform(
        (-200, -200, -290), (200, 200, 0), (50, 3)
    )
    fishes.orientation[:] = np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0  # ahead along x
    fishes.length[:], fishes.snout[:], fishes.live[::2] = 20.0, 6.0, True
    who = np.arange(-1, 50, dtype=np.int32)
    shear = shear_at(who, fishes, sea, ALONE, np.array(FLOW))
    middle, carried = fishes.position.copy(), []
    for along in (0.0, 6.0, -14.0):
        fishes.position[:] = middle + [along, 0.0, 0.0]
        set_drift(everyone(fishes), fishes, sea, ALONE, np.array(FLOW))
        add_bow_wave(everyone(fishes), fishes, sea)
        carried.append(fishes.drift.astype(float))
    for tip in (0, 1):
        expected = np.where(fishes.live[:, None], carried[tip + 1] - carried[0], 0.0)
        np.testing.assert_allclose(shear[1:, tip], expected, atol=1e-3)
    assert np.abs(shear).max() > 5.0
    assert not shear[0].any()


def test_a_dense_crowd_is_carried_past_without_meeting_the_pillar(make_sea):
    """A column of water that drifts against a pillar parts before it."""
    sea = make_sea(pillars=[(0.0, 0.0, 60.0, -20.0)])
    y = np.linspace(-80.0, 80.0, 41)
    here = np.stack([np.full(41, -200.0), y, np.full(41, -150.0)], axis=1)
    for _ in range(4000):
        flow = [flow_near(sea.pillars, NONE, (3.0, 0.0, 0.0), tuple(p)) for p in here]
        here = here + 0.033 * np.array(flow)
        assert np.hypot(here[:, 0], here[:, 1]).min() >= 60.0
    # Those that do not head for its very middle have passed, on the side where they were.
    passed = np.abs(y) > 25.0
    assert here[passed, 0].min() > 60.0
    assert (np.sign(here[passed, 1]) == np.sign(y[passed])).all()


def test_rocks_that_overlap_send_out_no_more_than_one():
    place = (95.0, 20.0, -250.0)
    one = np.array(flow_near(NO_PILLARS, ALONE, (3.0, 0.0, 0.0), place))
    five = np.array(
        flow_near(NO_PILLARS, all_rocks(np.repeat(ROCK, 5, axis=0)), (3.0, 0.0, 0.0), place)
    )
    np.testing.assert_allclose(five, one)
    assert one[0] > 4.0
