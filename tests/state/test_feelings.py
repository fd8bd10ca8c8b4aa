"""Feelings of a fish for single others."""

import numpy as np
import pytest

from subsea.state import FEELINGS, NOBODY, SUBMARINE
from subsea.state.feelings import FADING_S, dread_of, fade_feelings, feel, feeling_for


def test_a_feeling_grows_within_bounds_and_is_one_fishs_alone(tank):
    t = tank(3)
    for _ in range(4):
        feel(t.minds, 0, 2, 0.4)
        feel(t.minds, 0, SUBMARINE, -0.4)
    assert feeling_for(t.minds, 0, 2) == 1.0
    assert feeling_for(t.minds, 0, SUBMARINE) == -1.0
    assert feeling_for(t.minds, 0, 1) == feeling_for(t.minds, 2, 0) == 0.0


def test_the_weakest_feeling_makes_room_for_a_stronger_one(tank):
    t = tank(9)
    for j in range(1, FEELINGS + 1):
        feel(t.minds, 0, j, -0.1 * (j + 1))
    feel(t.minds, 0, 7, 0.15)  # weaker than all
    assert feeling_for(t.minds, 0, 7) == 0.0
    feel(t.minds, 0, 8, 0.6)
    assert feeling_for(t.minds, 0, 8) == pytest.approx(0.6)
    assert feeling_for(t.minds, 0, 1) == 0.0
    assert feeling_for(t.minds, 0, 2) == pytest.approx(-0.3)


def test_feelings_fade_over_minutes_however_often_a_fish_thinks(tank):
    t = tank(4)
    feel(t.minds, 0, 3, 0.8)
    feel(t.minds, 1, 3, 0.8)
    t.minds.pause[:2] = 0.5, 2.0
    for _ in range(4):
        fade_feelings(np.array([0]), t.minds)
    fade_feelings(np.array([1]), t.minds)
    assert feeling_for(t.minds, 0, 3) == pytest.approx(feeling_for(t.minds, 1, 3), rel=1e-4)
    t.minds.pause[:2] = FADING_S
    fade_feelings(np.array([0]), t.minds)
    assert feeling_for(t.minds, 0, 3) == pytest.approx(0.8 / np.e, rel=0.03)
    for _ in range(3):
        fade_feelings(np.array([0]), t.minds)
    assert (t.minds.liked[0] == NOBODY).all() and (t.minds.liking[0] == 0.0).all()


def test_a_predator_that_chased_is_feared_from_farther_and_timidity_counts(tank):
    t = tank(3)
    t.minds.timidity[1] = 1.5
    usual, timid = dread_of(t.minds, 0, 2, t.nature), dread_of(t.minds, 1, 2, t.nature)
    assert (usual, timid) == (200.0, 300.0)
    feel(t.minds, 0, 2, -0.5)
    assert dread_of(t.minds, 0, 2, t.nature) == pytest.approx(1.25 * usual)
    feel(t.minds, 0, SUBMARINE, 1.0)
    assert dread_of(t.minds, 0, SUBMARINE, t.nature) == 0.0
    assert dread_of(t.minds, 1, SUBMARINE, t.nature) == 1.5 * t.nature.submarine_cm
