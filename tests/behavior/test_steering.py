"""Urges constrained by bounds and solids."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior.steering import (
    BODY_BL,
    CLEARANCE_CM,
    HULL_AHEAD_S,
    ROOM_BL,
    STEEPEST,
    constrained,
    ease_goals,
    keep_clear,
)
from subsea.geometry.rotation import about
from subsea.state import EAT, ESCAPE, HULL_CM, LEFT, PREDATOR, PREY, SCHOOL, WANDER
from tests.support.scenes import everyone

ALL = np.arange(1)
angle = st.floats(0, 2 * np.pi)
direction = st.builds(
    lambda z, a: (float(np.sqrt(1 - z * z) * np.cos(a)), float(np.sqrt(1 - z * z) * np.sin(a)), z),
    st.floats(-1, 1), angle,
)  # fmt: skip


@given(direction, direction, st.floats(-50, 200))
def test_no_wish_heads_out_harder_than_the_distance_allows(urge, normal, distance):
    wish = np.array(constrained(urge, normal, distance, 80.0))
    assert np.linalg.norm(wish) == pytest.approx(1.0, abs=1e-6)
    least = -np.clip(distance / 80.0, -1, 1)
    assert wish @ normal >= least - 1e-6
    if np.dot(urge, normal) >= least:
        np.testing.assert_allclose(wish, urge)


@pytest.mark.parametrize(
    ("place", "outward"),
    [
        ((990.0, 0.0, -300.0), (1.0, 0.0, 0.0)),
        ((0.0, -992.0, -300.0), (0.0, -1.0, 0.0)),
        ((0.0, 0.0, -592.0), (0.5, 0.0, -0.8)),
        ((0.0, 0.0, -9.0), (0.5, 0.0, 0.8)),
    ],
)
def test_too_near_a_bound_the_wish_points_inward(tank, place, outward):
    t = tank()
    t.fishes.position[:] = place
    t.minds.urge[:] = outward
    keep_clear(ALL, t.fishes, t.minds, t.sea)
    away = np.array(outward) * (np.array(place) != 0)
    assert t.minds.urge[0] @ away < 0


def test_a_pillar_is_passed_and_its_top_is_free(tank):
    t = tank(pillars=[(100.0, 0.0, 50.0, -200.0)])
    t.fishes.position[:] = 40.0, 0.0, -300.0
    keep_clear(ALL, t.fishes, t.minds, t.sea)
    assert t.minds.urge[0, 0] < 0.05
    t.fishes.position[:] = 40.0, 0.0, -150.0
    t.minds.urge[:] = 1.0, 0.0, 0.0
    keep_clear(ALL, t.fishes, t.minds, t.sea)
    np.testing.assert_allclose(t.minds.urge[0], [1.0, 0.0, 0.0])


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("degrees", [2.0, 4.0])
def test_a_fish_turns_back_from_the_corner_of_a_pillar_and_the_wall(tank, side, degrees):
    t = tank(pillars=[(900.0, 0.0, 100.0, 0.0)])
    turn = np.radians(degrees)
    # Between the two, heading for where they meet.
    away = 0.5 * (1000.0 + 900.0 * np.cos(turn) + np.sqrt(100**2 - (900.0 * np.sin(turn)) ** 2))
    t.fishes.position[:] = away * np.cos(turn), side * away * np.sin(turn), -300.0
    t.minds.urge[:] = np.sin(turn), -side * np.cos(turn), 0.0
    t.fishes.orientation[:] = about(0.0, 0.0, 1.0, -side * 0.5 * np.pi)
    keep_clear(ALL, t.fishes, t.minds, t.sea)
    assert side * t.minds.urge[0, 1] > 0.5


def test_a_hunter_follows_its_prey_nearer_to_a_pillar(tank):
    sideways = []
    for kind, intention in ((PREDATOR, WANDER), (PREDATOR, EAT), (PREY, EAT)):
        t = tank(pillars=[(80.0, 2.0, 30.0, 0.0)])
        t.minds.kind[:], t.minds.intention[:] = kind, intention
        t.minds.urge[:] = 1.0, 0.0, 0.0
        keep_clear(ALL, t.fishes, t.minds, t.sea)
        sideways.append(abs(t.minds.urge[0, 1]))
    assert sideways[1] < 0.5 * sideways[0]
    assert sideways[2] == sideways[0]


def test_the_way_around_an_ellipsoid(tank):
    t = tank(rocks=[(60.0, 0.0, -300.0, 30.0, 90.0, 40.0, 0.0)])
    t.fishes.position[:] = 15.0, 0.0, -300.0
    keep_clear(ALL, t.fishes, t.minds, t.sea)
    assert t.minds.urge[0, 0] < 0.1
    assert np.hypot(*t.minds.urge[0, 1:]) > 0.9


def test_goals_turn_smoothly_and_stay_unit_vectors(tank):
    t = tank()
    rng = np.random.default_rng(2)
    before = t.fishes.goal_direction[0].copy()
    for tick in range(600):
        if tick % 20 == 0:
            t.minds.urge[:] = rng.normal(size=3)
        ease_goals(everyone(t.fishes), t.fishes, t.minds, t.at(tick).clock)
        now = t.fishes.goal_direction[0]
        assert abs(np.linalg.norm(now) - 1) < 1e-5
        assert now @ before > np.cos(np.radians(25))
        before = now.copy()


def test_a_warning_makes_the_turn_smaller(tank):
    """min(1, 1.5 + M) of the angle (Tu §6.5.3); a preference for that side does nothing."""
    turned = []
    for preference in (0.0, -0.4, -1.0, 0.7):
        t = tank()
        t.minds.urge[:] = 0.0, 1.0, 0.0
        t.minds.preference[:, LEFT] = preference
        ease_goals(everyone(t.fishes), t.fishes, t.minds, t.clock)
        turned.append(np.arctan2(t.fishes.goal_direction[0, 1], t.fishes.goal_direction[0, 0]))
    np.testing.assert_allclose(np.array(turned) / turned[0], [1, 1, 0.5, 1], rtol=1e-4)


@given(bearing=direction, along=direction, speed=st.floats(0, 120), off=st.floats(70, 90))
def test_no_wish_leads_into_the_submarine(tank, bearing, along, speed, off):
    """At the closest approach the urge heads for it no harder than the distance allows."""
    one = tank()
    here = one.fishes.position[0].astype(float)
    hull = here - off * np.array(bearing)
    one.sea.submarine[:3], one.sea.submarine[3:6] = hull, speed * np.array(along)
    one.minds.urge[0] = -np.array(bearing)
    keep_clear(ALL, one.fishes, one.minds, one.sea)
    until = np.clip(off * np.dot(bearing, along) / speed, 0, HULL_AHEAD_S) if speed > 1 else 0.0
    away = here - hull - until * speed * np.array(along)
    if np.linalg.norm(away) > 1:
        room = (np.linalg.norm(away) - HULL_CM - BODY_BL * 20 - CLEARANCE_CM) / (ROOM_BL * 20)
        least = -np.clip(room, -1, 1)
        assert one.minds.urge[0] @ away / np.linalg.norm(away) >= least - 1e-3


def test_the_submarine_is_given_way_aside(tank):
    one = tank()
    one.sea.submarine[:6] = -150.0, -5.0, -300.0, 120.0, 0.0, 0.0
    keep_clear(ALL, one.fishes, one.minds, one.sea)
    assert one.minds.urge[0, 1] > 0.7


def test_urges_are_flat_unless_the_fish_flees_or_feeds(tank):
    for intention, steep in ((WANDER, False), (SCHOOL, False), (ESCAPE, True), (EAT, True)):
        one = tank()
        one.minds.intention[:], one.minds.urge[:] = intention, (3.0, 0.0, 4.0)
        keep_clear(ALL, one.fishes, one.minds, one.sea)
        climb = 0.8 if steep else STEEPEST
        level = np.sqrt(1.0 - climb**2)
        np.testing.assert_allclose(one.minds.urge[0], [level, 0.0, climb], rtol=1e-5)
