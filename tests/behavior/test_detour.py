"""The side on which a schooling fish passes an obstacle."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from subsea.behavior.detour import AWAY, BERTH_BL, HEADROOM_BL, LOOK_BL, detour
from subsea.behavior.schooling import DIRECT
from subsea.geometry.vector import ZERO

LENGTH = 20.0
BERTH = BERTH_BL * LENGTH
AHEAD = (1.0, 0.0, 0.0)
NONE = np.zeros((0, 7))
NO_PILLARS = np.zeros((0, 4))


def way_round(pillars, rocks=NONE, heading=AHEAD, wish=AHEAD, here=(0.0, 0.0, -200.0), direct=0.0):
    """Call `detour` with a fish in the types of `Fishes`."""
    fish = tuple(np.float32(heading)), tuple(np.float32(here)), np.float32(LENGTH)
    return detour(wish, *fish, pillars, rocks, direct)


def way_past(pillar, **fish):
    return way_round(np.array([pillar]), **fish)


@pytest.mark.parametrize(
    ("pillar", "why"),
    [
        ((150.0, 40.0 + BERTH + 1.0, 40.0, -50.0), "aside"),
        ((-100.0, 0.0, 40.0, -50.0), "behind"),
        ((41.0 + LOOK_BL * LENGTH, 0.0, 40.0, -50.0), "far"),
        ((150.0, 0.0, 40.0, -201.0), "below"),
    ],
)
def test_pillars_aside_behind_far_or_below_are_ignored(pillar, why):
    assert way_past(pillar) == ZERO
    assert way_past((150.0, 0.0, 40.0, -50.0)) != ZERO


@given(
    x=st.floats(70.0, 250.0), y=st.floats(-60.0, 60.0),
    turn=st.floats(-0.5, 0.5), radius=st.floats(20.0, 60.0),
)  # fmt: skip
def test_the_way_is_the_tangent_on_the_side_that_the_fish_heads_to(x, y, turn, radius):
    heading = np.float32([np.cos(turn), np.sin(turn), 0.0]).astype(float)
    widest = np.arcsin(min((radius + BERTH) / np.hypot(x, y), 1.0)) + abs(np.arctan2(y, x))
    assume(widest < 0.5 * np.pi)  # else one of the sides leads away from the wish
    way = way_past((x, y, radius, -50.0), heading=heading)
    if way == ZERO:
        assert abs(y) >= radius + BERTH or x - radius > LOOK_BL * LENGTH - 60.0
        return
    assert np.linalg.norm(way) == pytest.approx(1.0)
    left = heading[0] * y - heading[1] * x  # the middle is to the left if this is positive
    passes = way[0] * y - way[1] * x
    assert passes * left >= -1e-9
    assert abs(passes) == pytest.approx(min(radius + BERTH, np.hypot(x, y)), rel=1e-6)


def test_a_fish_beside_an_obstacle_is_not_drawn_back_in_front_of_it():
    """With the leader on the far side, the wish leads through; the heading passes on the right."""
    way = way_past((60.0, 30.0, 40.0, -50.0), heading=(0.7, -0.7, 0.0), wish=(0.5, 0.9, 0.0))
    assert way[1] < 0.0


def test_a_straggler_passes_on_the_side_of_its_school():
    pillar = (60.0, 30.0, 40.0, -50.0)
    there = {"heading": (0.7, -0.7, 0.0), "wish": (0.5, 0.9, 0.0)}
    assert way_past(pillar, **there)[1] < 0.0
    assert way_past(pillar, **there, direct=DIRECT)[1] > 0.0


def test_of_two_fishes_abreast_each_takes_its_own_side():
    pillar = (150.0, 0.0, 40.0, -50.0)
    left, right = (way_past(pillar, here=(0.0, y, -200.0)) for y in (5.0, -5.0))
    assert left[1] > 0.0 > right[1]
    assert left[1] == pytest.approx(-right[1])


def test_the_nearest_of_several_counts_rocks_among_them():
    pillars = np.array([[200.0, 5.0, 30.0, -50.0]])
    rock = np.array([[100.0, -5.0, -200.0, 40.0, 20.0, 30.0, 0.0]])
    assert way_round(pillars)[1] < 0.0
    assert way_round(pillars, rock)[1] > 0.0
    rock[0, 2] = -260.0  # its top is below the fish
    assert way_round(pillars, rock)[1] < 0.0


def test_a_fish_that_turns_back_ignores_obstacles_ahead():
    pillar = (150.0, 0.0, 40.0, -50.0)
    assert way_past(pillar, wish=(-1.0, 0.2, 0.0)) == ZERO
    assert way_past(pillar, wish=(1.0, 5.0, 0.0)) != ZERO


PLACE = st.tuples(st.floats(40.0, 250.0), st.floats(-3.0, 3.0), st.floats(5.0, 40.0))


@given(
    places=st.lists(PLACE, min_size=1, max_size=5),
    turn=st.floats(-1.5, 1.5),
    direct=st.floats(0.0, DIRECT),
)
def test_the_way_leads_into_nothing_else_and_no_such_way_is_nearer(places, turn, direct):
    """Compare with a brute-force search over all tangents of all pillars."""
    pillars = np.array([(d * np.cos(a), d * np.sin(a), r, 0.0) for d, a, r in places])
    pillars = pillars[np.hypot(*pillars[:, :2].T) > pillars[:, 2] + BERTH + 1.0]
    heading = np.array([np.cos(turn), np.sin(turn), 0.0])
    way = way_round(pillars, heading=heading, direct=direct)
    if way == ZERO:
        return
    bearing, reach = np.arctan2(pillars[:, 1], pillars[:, 0]), np.hypot(*pillars[:, :2].T)
    half = np.arcsin((pillars[:, 2] + BERTH) / reach)
    near = reach - pillars[:, 2] <= LOOK_BL * LENGTH

    def apart(a, b):
        return np.abs((a - b + np.pi) % (2.0 * np.pi) - np.pi)

    def cost(way):
        off = apart(way, 0.0)
        return apart(way, turn) + direct * off + AWAY * np.maximum(off - 0.5 * np.pi, 0.0)

    ways = np.concatenate([bearing[near] - half[near], bearing[near] + half[near]])
    free = [(apart(bearing[near], w) > half[near] - 2e-3).all() for w in ways]
    if not any(free):
        return
    chosen = np.arctan2(way[1], way[0])
    assert (apart(bearing[near], chosen) > half[near] - 0.02).all()
    strictly = [(apart(bearing[near], w) > half[near] - 1e-9).all() for w in ways]
    if any(strictly):
        assert cost(chosen) <= cost(ways)[strictly].min() + 1e-6


def test_a_rock_is_as_wide_as_it_is_at_the_height_of_the_fish():
    """At half its height, less the headroom, an ellipsoid has √3/2 of its width."""
    high = 30.0
    for side in (1.0, -1.0):
        middle = -200.0 + side * (0.5 * high + HEADROOM_BL * LENGTH)
        rock = np.array([[150.0, 0.0, middle, 40.0, 20.0, high, 0.3]])
        way = way_round(NO_PILLARS, rock)
        sine = (40.0 * np.sqrt(0.75) + BERTH) / 150.0
        assert abs(way[1]) == pytest.approx(sine)
    rock[0, 2] = -200.0 + high + HEADROOM_BL * LENGTH + 0.1
    assert way_round(NO_PILLARS, rock) == ZERO


def test_through_an_arch_it_swims_between_the_legs():
    """Pass between two legs to the leader beyond, not around the outside."""
    legs = np.array([[120.0, 100.0, 50.0, 0.0], [120.0, -100.0, 50.0, 0.0]])
    wish = (1.0, 0.6, 0.0)  # into the left leg
    way = way_round(legs, wish=wish)
    assert abs(np.arctan2(way[1], way[0])) < np.radians(15.0)


def test_it_rather_turns_than_goes_round_the_far_side_of_a_long_wall():
    """A fish beside a row of pillars turns back to the near end to reach a place behind it."""
    row = np.array([(60.0, y, 30.0, 0.0) for y in np.arange(-40.0, 241.0, 40.0)])
    fish = {"heading": (0.05, 1.0, 0.0), "here": (0.0, -20.0, -200.0)}
    assert way_round(row, wish=(0.6, -0.8, 0.0), **fish)[1] < 0.0
    assert way_round(row, wish=(0.6, 0.8, 0.0), **fish)[1] > 0.0
