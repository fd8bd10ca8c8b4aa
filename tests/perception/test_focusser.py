"""Targets and motor preferences in Tu's examples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.perception.focusser import focus, most_desirable
from subsea.state import (
    ASCEND,
    AVOID,
    BACKWARD,
    DESCEND,
    EAT,
    ESCAPE,
    FEAR,
    FORWARD,
    HUNGER,
    LEFT,
    LIBIDO,
    LOOPING,
    MATE,
    PREDATOR,
    RIGHT,
    SUBMARINE,
    WANDER,
)

EYE = np.array([7.0, 0.0, -300.0])
# The fish heads along x with its back up, so y is to its left.
AHEAD, ASTERN, TO_LEFT, TO_RIGHT = (30, 0, 0), (-30, 0, 0), (0, 30, 0), (0, -30, 0)
ABOVE, BELOW = (0, 0, 30), (0, 0, -30)


def _put(t, *gaps):
    """Place all fishes but the first, relative to the first one's eye."""
    t.fishes.position[1:] = EYE + np.array(gaps, float)


def _preference(t):
    t.run(focus, 0)
    return t.minds.preference[0]


# Motor preferences.


def test_three_mates_and_a_predator_to_the_left(tank):
    """Tu's example of §6.5.2: M(LEFT) = 3 tau_m / 3 - tau_f."""
    t = tank(5)
    _put(t, (0, 40, 0), (5, 60, 0), (0, 50, 10), (0, 200, 0))
    t.minds.mates[0] = 1, 2, 3
    t.minds.predators[0, 0] = 4
    t.minds.mental[0, LIBIDO], t.minds.mental[0, FEAR] = 0.6, 0.35
    np.testing.assert_allclose(_preference(t), [0.6 - 0.35, 0, 0, 0, 0, 0], atol=1e-6)


def test_an_obstacle_to_the_left_and_food_to_the_right(tank):
    """Tu's first example: M(LEFT) = -tau_a, M(RIGHT) = tau_e."""
    t = tank(specks=1, pillars=[(7.0, 30.0, 10.0, -100.0)])
    t.sea.plankton[0] = EYE + TO_RIGHT
    t.minds.foods[0, 0] = 0
    t.minds.mental[0, HUNGER] = 0.7
    np.testing.assert_allclose(_preference(t), [-1.0, 0.7, 0, 0, 0, 0], atol=1e-6)


@pytest.mark.parametrize(
    ("gap", "sides"),
    [
        (AHEAD, [FORWARD]), (ASTERN, [BACKWARD]), (TO_LEFT, [LEFT]), (TO_RIGHT, [RIGHT]),
        (ABOVE, [ASCEND]), (BELOW, [DESCEND]), ((30, 30, 0), [FORWARD, LEFT]),
        ((30, -30, 30), [FORWARD, RIGHT, ASCEND]), ((30, 10, 0), [FORWARD]),
    ],
)  # fmt: skip
def test_directions_in_body_axes(tank, gap, sides):
    t = tank(2)
    _put(t, gap)
    t.minds.mates[0, 0], t.minds.mental[0, LIBIDO] = 1, 0.5
    expected = np.zeros(6)
    expected[sides] = 0.5
    np.testing.assert_allclose(_preference(t), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("intention", "strength"), [(ESCAPE, 0.4), (EAT, 0.8), (MATE, 0.5), (AVOID, 1.0), (WANDER, 1.0)]
)
def test_desires_count_against_the_intention(tank, intention, strength):
    """Tau is each desire over that of the present intention, at most 1 (Tu §7.6)."""
    t = tank(3, specks=1)
    _put(t, (0, 60, 0), (60, 0, 0))
    t.sea.plankton[0] = EYE + TO_RIGHT
    t.minds.mates[0, 0], t.minds.predators[0, 0], t.minds.foods[0, 0] = 1, 2, 0
    t.minds.mental[0] = 0.8, 0.5, 0.4
    t.minds.intention[0] = intention
    wanted = np.minimum(np.array([0.8, 0.5, 0.4]) / strength, 1.0)
    found = _preference(t)
    np.testing.assert_allclose(found[[RIGHT, LEFT, FORWARD]], wanted * (1, 1, -1), rtol=1e-5)


@pytest.mark.parametrize(
    ("place", "side"),
    [
        ((0, 0, -590), DESCEND), ((0, 0, -10), ASCEND), ((980, 0, -300), FORWARD),
        ((0, 980, -300), LEFT), ((0, -980, -300), RIGHT), ((-980, 0, -300), BACKWARD),
    ],
)  # fmt: skip
def test_bounds_are_warned_of(tank, place, side):
    t = tank()
    t.fishes.position[0] = place
    expected = np.zeros(6)
    expected[side] = -1.0
    np.testing.assert_allclose(_preference(t), expected, atol=1e-6)


def test_a_threat_and_a_crowd_are_warned_of_but_not_a_school_at_its_distance(tank):
    t = tank(4)
    t.fishes.position[1:] += np.array([[0, 8, 0], [0, 20, 0], [0, 0, 9]])
    t.minds.neighbour[0, :3] = 1, 3, 2
    np.testing.assert_allclose(_preference(t), [-1, 0, 0, 0, -1, 0], atol=1e-6)
    t.minds.neighbour[0] = -1
    t.minds.threat[0] = 2
    assert _preference(t)[LEFT] == -1


@given(st.integers(0, 2**32 - 1))
def test_preferences_stay_between_minus_one_and_one(tank, seed):
    rng = np.random.default_rng(seed)
    t = tank(12, specks=3, rocks=[(20, 5, -300, 9, 8, 7, 1.0)])
    t.fishes.position[:] += rng.normal(0, 15, (12, 3))
    t.sea.plankton[:] = t.fishes.position[0] + rng.normal(0, 30, (3, 3))
    t.minds.mates[0], t.minds.predators[0] = (1, 2, 3), (4, 5, SUBMARINE)
    t.minds.foods[0] = 0, 1, 2
    t.minds.neighbour[0], t.minds.threat[0] = range(5, 12), 6
    t.minds.mental[0] = rng.uniform(0, 1, 3)
    t.minds.intention[0] = rng.integers(0, 7)
    assert (np.abs(_preference(t)) <= 1.0 + 1e-6).all()


# Targets.


def _chosen(t, desire, place, preference):
    targets = np.arange(len(place), dtype=np.int32)
    return most_desirable(
        t.fishes, 0, targets, np.array(desire), (EYE + place).astype(np.float32),
        np.array(preference, np.float32),
    )  # fmt: skip


def test_the_choice_between_targets(tank):
    """The rule of Tu §6.5.3, and its second example of §6.5.2."""
    t = tank()
    place = np.array([AHEAD, TO_LEFT])
    calm, leftward = np.zeros(6), np.eye(6)[LEFT]
    assert _chosen(t, [0.9, 0.8], place, calm) == 0
    assert _chosen(t, [0.9, 0.8], place, leftward) == 1  # 0.9 against 0.8 + 0.2
    assert _chosen(t, [0.9, 0.65], place, leftward) == 0  # far better
    assert _chosen(t, [0.9, 0.75], place, 0.7 * leftward) == 0
    assert _chosen(t, [0.9, 0.85], np.array([TO_RIGHT, AHEAD]), -np.eye(6)[RIGHT]) == 1
    assert _chosen(t, [0.3], place[:1], -np.eye(6)[FORWARD]) == 0
    assert _chosen(t, [], np.zeros((0, 3)), calm) == -1


def _eater(tank, *gaps):
    t = tank(specks=len(gaps))
    t.sea.plankton[:] = EYE + np.array(gaps, float)
    t.minds.intention[0], t.minds.mental[0, HUNGER] = EAT, 0.5
    order = np.argsort(np.linalg.norm(gaps, axis=1))[:3]
    t.minds.foods[0, : len(order)] = order
    return t


def test_an_eater_takes_the_nearest_speck_and_keeps_it(tank):
    t = _eater(tank, (200, 0, 0), (150, 0, 0))
    t.run(focus)
    assert t.minds.target[0] == 1
    t.minds.target[0] = 0
    t.run(focus)
    assert t.minds.target[0] == 1  # 50 cm nearer, more than its devotion
    t.sea.plankton[0, 0] = EYE[0] + 170
    t.minds.target[0] = 0
    t.run(focus)
    assert t.minds.target[0] == 0
    t.sea.absent[0] = 1.0
    t.minds.foods[0] = 1, -1, -1
    t.run(focus)
    assert t.minds.target[0] == 1
    t.minds.foods[0] = -1
    t.run(focus)
    assert t.minds.target[0] == -1


def test_a_fickle_fish_changes_its_mind_sooner(tank):
    t = _eater(tank, (170, 0, 0), (150, 0, 0))
    t.minds.target[0] = 0
    t.run(focus)
    assert t.minds.target[0] == 0
    t = t._replace(nature=t.nature._replace(devotion_cm=5.0))
    t.run(focus)
    assert t.minds.target[0] == 1


def test_hungry_and_in_love_it_eats_on_the_way_to_the_mate(tank):
    """Tu's second example: the speck ahead is nearer, the mate and another speck are left."""
    t = tank(2, specks=2)
    t.sea.plankton[:] = EYE + np.array([[150, 0, 0], [0, 180, 0]])
    t.minds.foods[0, :2], t.minds.intention[0] = (0, 1), EAT
    t.minds.mental[0] = 0.6, 0.0, 0.0
    _put(t, (0, 300, 0))
    t.minds.mates[0, 0] = 1
    t.run(focus, 0)
    assert t.minds.target[0] == 0
    t.minds.mental[0, LIBIDO], t.minds.target[0] = 0.5, -1
    t.run(focus, 0)
    assert t.minds.target[0] == 1


def test_a_predator_takes_the_prey_that_costs_least_and_keeps_it(tank):
    t = tank(3)
    t.minds.kind[0], t.minds.intention[0] = PREDATOR, EAT
    _put(t, (100, 0, 0), (130, 0, 0))
    t.minds.foods[0, :2] = 1, 2
    t.run(focus, 0)
    assert t.minds.target[0] == 1
    t.minds.target[0] = 2
    t.run(focus, 0)
    assert t.minds.target[0] == 1  # 130 against 100
    # 130 against 150: now the other is the better one.
    t.minds.leads[1], t.minds.neighbour[1, 0] = True, 2
    t.minds.foods[0, :2], t.minds.target[0] = (2, 1), 1
    t.run(focus, 0)
    assert t.minds.target[0] == 1  # 20 cm are less than its devotion
    t.fishes.alive[1] = False
    t.minds.foods[0, :2] = 2, -1
    t.run(focus, 0)
    assert t.minds.target[0] == 2


def _suitor(tank, male):
    t = tank(4)
    t.minds.intention[0] = MATE
    t.minds.male[0], t.minds.male[1:] = male, not male
    _put(t, (60, 0, 0), (90, 0, 0), (40, 0, 0))
    t.fishes.length[1:] = 20.0, 40.0, 20.0
    t.fishes.species[3] = 1
    t.minds.mates[0] = 1, 2, 3
    return t


def test_a_male_likes_the_near_one_and_a_female_the_large_one(tank):
    for male, best in ((True, 1), (False, 2)):
        t = _suitor(tank, male)
        t.run(focus, 0)
        assert t.minds.target[0] == best


def test_a_courting_fish_is_devoted_while_the_other_is_in_sight(tank):
    t = _suitor(tank, male=True)
    t.fishes.position[2, 0] = EYE[0] + 80.0
    t.minds.target[0] = 2
    t.run(focus, 0)
    assert t.minds.target[0] == 2
    t.fishes.position[2, 0] = EYE[0] - 80.0  # astern, where the male does not see her
    t.run(focus, 0)
    assert t.minds.target[0] == 1


def test_a_courtship_keeps_its_own_target(tank):
    t = _suitor(tank, male=True)
    t.minds.courtship[0], t.minds.target[0] = LOOPING, 3
    t.run(focus, 0)
    assert t.minds.target[0] == 3


def test_avoid_and_escape_are_about_the_most_dangerous(tank):
    t = tank(3)
    t.minds.threat[0], t.minds.predator[0] = 2, SUBMARINE
    for intention, target in ((AVOID, 2), (ESCAPE, SUBMARINE)):
        t.minds.intention[0] = intention
        t.run(focus, 0)
        assert t.minds.target[0] == target
