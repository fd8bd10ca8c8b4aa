"""Collision detection in situations with an obvious answer."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.rotation import from_matrix
from subsea.perception.collision import (
    BERTH_WIDTHS,
    ENLARGED,
    HELD,
    find_barriers,
    find_threats,
    nearest_barrier,
    share_inside,
)
from subsea.perception.crowd import crowd_of
from subsea.perception.vision import along_body
from subsea.state import (
    APPROACHING,
    AVOID,
    CIRCLING,
    CLEAN,
    EAT,
    GRAZE,
    NOBODY,
    POSE,
    PREDATOR,
    SCHOOL,
    SEABED,
    SURFACE,
    WALL,
)

BACK = np.array([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])  # upright, heading against x


def _threats(t):
    who = np.arange(len(t.fishes.length))
    find_threats(who, t.fishes, t.minds, crowd_of(t.fishes), t.nature)
    return list(t.minds.threat)


def _pair(tank, gap, against=False, **nature):
    """Two fishes, the second `gap` cm from the first, heading along or against x."""
    t = tank(2, **nature)
    t.fishes.position[1] += np.array(gap, np.float32)
    if against:
        t.fishes.orientation[1], t.fishes.velocity[1] = BACK, (-15.0, 0.0, 0.0)
    return t


def test_two_that_meet_head_on_are_in_danger_and_far_apart_not(tank):
    assert _threats(_pair(tank, (35.0, 0.0, 0.0), against=True)) == [1, 0]
    assert _threats(_pair(tank, (90.0, 0.0, 0.0), against=True)) == [NOBODY, NOBODY]
    # They pass at a distance.
    assert _threats(_pair(tank, (35.0, 15.0, 0.0), against=True)) == [NOBODY, NOBODY]


@pytest.mark.parametrize("gap", [(0.0, 20.0, 0.0), (25.0, 0.0, 0.0), (0.0, 0.0, 20.0), (9, 9, 0)])
def test_one_that_swims_alongside_or_ahead_is_no_danger(tank, gap):
    assert _threats(_pair(tank, gap)) == [NOBODY, NOBODY]


def test_a_fish_that_closes_in_from_the_side_is_a_threat(tank):
    t = _pair(tank, (5.0, 16.0, 0.0))
    t.fishes.velocity[1] = 15.0, -20.0, 0.0
    assert _threats(t)[0] == 1
    t.fishes.velocity[1] = 15.0, 20.0, 0.0
    assert _threats(t)[0] == NOBODY


def test_a_fish_behind_is_no_threat(tank):
    t = _pair(tank, (25.0, 0.0, 0.0))
    t.fishes.velocity[0] = 40.0, 0.0, 0.0
    # The fish behind runs into the other, which does not see it.
    assert _threats(t) == [1, NOBODY]


def test_timid_fishes_turn_earlier(tank):
    gap = (55.0, 0.0, 0.0)
    assert _threats(_pair(tank, gap, against=True))[0] == NOBODY
    assert _threats(_pair(tank, gap, against=True, timidity=2.0))[0] == 1


def test_in_formation_fishes_tolerate_smaller_distances(tank):
    t = _pair(tank, (38.0, 0.0, 0.0), against=True)
    assert _threats(t)[0] == 1
    t.minds.intention[:] = SCHOOL
    assert _threats(t)[0] == NOBODY
    # Also while the school is only interrupted.
    t.minds.intention[:], t.minds.memory[:], t.minds.threat[:] = AVOID, SCHOOL, NOBODY
    assert _threats(t)[0] == NOBODY


def test_a_cleaner_and_its_client_touch_and_grazers_tolerate_each_other(tank):
    t = _pair(tank, (38.0, 0.0, 0.0), against=True)
    t.minds.intention[:] = GRAZE
    assert _threats(t) == [NOBODY, NOBODY]
    t = _pair(tank, (20.0, 0.0, 0.0), against=True)
    t.minds.intention[:] = CLEAN, POSE
    assert _threats(t) == [1, 0]
    t.minds.client[0], t.minds.cleaner[1] = 1, 0
    assert _threats(t) == [NOBODY, NOBODY]


def test_a_threat_is_avoided_until_it_is_well_clear(tank):
    """Place a fish just outside the region, but inside the larger one of a fish that avoids."""
    t = _pair(tank, (0.0, 0.0, 0.0), against=True)
    gaps = np.arange(30.0, 70.0, 0.5)

    def farthest():
        near = []
        for gap in gaps:
            t.fishes.position[1, 0] = gap
            t.minds.threat[:] = 1
            if _threats(t)[0] == 1:
                near.append(gap)
        return max(near)

    calm = farthest()
    t.minds.intention[0] = AVOID
    assert calm + 3.0 < farthest() < HELD * calm


def test_partners_and_prey_may_be_touched(tank):
    t = _pair(tank, (20.0, 0.0, 0.0), against=True)
    t.minds.partner[:] = 1, 0
    t.minds.courtship[:] = APPROACHING
    assert _threats(t) == [1, 0]
    t.minds.courtship[:] = CIRCLING
    assert _threats(t) == [NOBODY, NOBODY]

    t = _pair(tank, (20.0, 0.0, 0.0), against=True)
    t.minds.kind[0], t.minds.intention[0], t.minds.target[0] = PREDATOR, EAT, 1
    assert _threats(t) == [NOBODY, 0]
    t.minds.target[0] = NOBODY
    assert _threats(t) == [1, 0]


def test_the_dead_are_in_nobodys_way(tank):
    t = _pair(tank, (20.0, 0.0, 0.0), against=True)
    t.fishes.alive[1] = False
    assert _threats(t)[0] == NOBODY


def test_the_one_with_most_of_its_body_inside_is_worst(tank):
    t = tank(3)
    t.fishes.position[1:] = (20.0, 2.0, -300.0), (18.0, 4.0, -300.0)
    # One lies across the way, the other approaches head-on with its whole body.
    t.fishes.orientation[1:] = (0.5, 0.5, 0.5, 0.5), BACK
    t.fishes.velocity[1:] = (0.0, 0.0, 0.0), (-15.0, -6.0, 0.0)
    bodies = t.fishes
    shares = [share_inside(bodies, 0, j, ENLARGED * 0.08, ENLARGED * 0.6) for j in (1, 2)]
    assert 0.0 < shares[0] < shares[1]
    assert _threats(t)[0] == 2


@given(st.integers(0, 2**32 - 1))
def test_the_search_misses_nobody(tank, seed):
    """Compare with all pairs of fishes of all sizes and speeds."""
    rng = np.random.default_rng(seed)
    n = 120
    t = tank(n)
    t.fishes.length[:] = rng.choice([8.0, 20.0, 30.0, 120.0], n)
    t.fishes.snout[:] = 0.3 * t.fishes.length
    t.fishes.girth[:] = t.fishes.length[:, None] * (0.2, 0.1)
    t.fishes.position[:] = rng.normal((0, 0, -300), 90, (n, 3))
    t.fishes.velocity[:] = rng.normal(0, 40, (n, 3))
    turn = rng.normal(size=(n, 4))
    t.fishes.orientation[:] = turn / np.linalg.norm(turn, axis=1)[:, None]
    found = _threats(t)
    bodies = t.fishes
    p = np.array([along_body(bodies, i, 0.5) for i in range(n)])
    for i in range(n):
        shares = [
            share_inside(bodies, i, j, ENLARGED * 0.08, ENLARGED * 0.6) if j != i else 0.0
            for j in range(n)
        ]
        gaps = ((p - p[i]) ** 2).sum(axis=1)
        best = min(range(n), key=lambda j: (-shares[j], gaps[j], j))
        assert found[i] == (best if shares[best] > 0 else NOBODY)


# Static obstacles.


def _barrier(t):
    find_barriers(np.arange(1), t.fishes, t.minds, t.sea, t.nature)
    return t.minds.barrier[0]


@pytest.mark.parametrize(
    ("place", "heading", "barrier"),
    [
        ((0, 0, -300), (1, 0, 0), -1),
        ((0, 0, -590), (0.6, 0, -0.8), SEABED),
        ((0, 0, -590), (0.6, 0, 0.8), -1),
        ((0, 0, -15), (0.6, 0, 0.8), SURFACE),
        ((0, 0, -15), (0.6, 0, -0.8), -1),
        ((970, 0, -300), (1, 0, 0), WALL),
        ((970, 0, -300), (-1, 0, 0), -1),
        ((0, -975, -300), (0.6, -0.8, 0), WALL),
        ((60, 100, -300), (1, 0, 0), 0),
        ((140, 100, -300), (1, 0, 0), -1),
        ((60, -100, -300), (1, 0, 0), 1),
        ((100, -100, -240), (0, 0, -1), 1),
        ((100, 100, -90), (0.6, 0, -0.8), 0),
    ],
)
def test_barriers(tank, place, heading, barrier):
    t = tank(pillars=[(100, 100, 10, -100)], rocks=[(100, -100, -300, 15, 20, 30, 0.5)])
    t.fishes.position[0] = place
    t.fishes.orientation[0] = _heading(heading)
    assert _barrier(t) == barrier


def _heading(x):
    """Orientation of a body with x axis `x` and its back up as far as possible."""
    x = np.array(x, float)
    right = np.cross(x, (0.0, 0.0, 1.0))
    if np.linalg.norm(right) < 1e-6:
        right = np.array([0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    return from_matrix(np.stack([x, np.cross(right, x), right], axis=1))


def test_a_wide_body_keeps_a_wider_berth(tank):
    t = tank(pillars=[(40, 14, 10, -100)])
    assert _barrier(t) == -1
    t.fishes.girth[0, 1] = 3.0  # 1.5 times that is more than 4
    assert _barrier(t) == 0


def test_the_nearer_boundary_counts(tank):
    t = tank(pillars=[(60, 0, 25, -100), (40, 0, 10, -100)])
    assert _barrier(t) == 1


def test_the_boundary_nearest_to_the_eye_counts_though_the_ray_meets_another_first(tank):
    """A pillar whose flank the ray grazes late is nearer than the one that it meets first."""
    pillars = [(46, 0, 10, -100), (36, 21, 19, -100)]
    assert _barrier(tank(pillars=pillars[:1])) == 0
    assert _barrier(tank(pillars=pillars[1:])) == 0
    eye = np.array([7.0, 0.0])
    gaps = [np.linalg.norm(eye - pillar[:2]) - pillar[2] for pillar in pillars]
    assert gaps[1] < gaps[0]
    assert _barrier(tank(pillars=pillars)) == 1


@pytest.mark.parametrize(("girth", "found"), [((2.0, 20.0), -1), ((20.0, 20.0), SEABED)])
def test_a_flat_body_needs_less_room_above_the_seabed(tank, girth, found):
    t = tank()
    t.fishes.position[0], t.fishes.girth[0] = (0.0, 0.0, -580.0), girth
    t.fishes.orientation[0] = _heading((0.98, 0.0, -0.2))
    assert _barrier(t) == found


@pytest.mark.parametrize(("apart", "found"), [(10.0, 0), (20.0, -1)])
def test_a_fish_that_keeps_to_the_ground_minds_only_near_stones(tank, apart, found):
    """Its antenna is 0.4 times 30 cm; the berth is 0.6 widths of 2 cm."""
    t = tank(pillars=[(7.0 + apart + 10.0, 0.0, 10.0, -100.0)])
    assert _barrier(t) == 0
    t.minds.barrier[0], t.minds.cruise_height[0] = -1, (10.0, 20.0)
    assert _barrier(t) == found


def test_an_antenna_is_as_long_as_asked(tank):
    t = tank(pillars=[(60, 0, 10, -100)])  # 40 cm before the eye, with the berth
    bodies, scene = t.fishes, t.sea
    assert nearest_barrier(bodies, 0, scene, 39.9, BERTH_WIDTHS) == -1
    assert nearest_barrier(bodies, 0, scene, 40.1, BERTH_WIDTHS) == 0
    t.minds.barrier[0] = -1
    assert _barrier(t) == -1
    t.minds.intention[0], t.minds.barrier[0] = AVOID, 0
    t.fishes.position[0, 0] = 4.0
    assert _barrier(t) == 0  # 36 cm: within 1.3 antennae of 30 cm
