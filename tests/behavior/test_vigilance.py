"""Closing up, keeping clear, hiding and watching."""

import numpy as np
import pytest

from subsea.behavior.vigilance import (
    ASIDE_RAD,
    CLEAR,
    HOVER,
    PUSH,
    REMEMBERED,
    away_from_threat,
    haste,
    is_hidden,
    watch,
    watch_desire,
)
from subsea.state import FEAR, NOBODY, PREDATOR, PREY


@pytest.fixture
def pair(tank):
    """A prey at (0, 0) and a predator at (-100, 0) that swims along x."""
    t = tank(2)
    t.minds.kind[:] = PREY, PREDATOR
    t.fishes.position[1, 0] = -100.0
    t.fishes.velocity[1] = 60.0, 0.0, 0.0
    t.minds.mental[0, FEAR], t.minds.predator[0] = 0.7, 1
    t.minds.menace[0] = t.minds.menaces[0] = 0.7
    t.minds.unseen[0], t.minds.threat_place[0] = 0.0, t.fishes.position[1]
    return t


def _away(t):
    return np.array(away_from_threat(t.fishes, t.minds, 0, t.sea, t.nature))


@pytest.mark.parametrize("angle", [5, 60, 90, 130])
@pytest.mark.parametrize("side", [1, -1])
def test_fishes_pass_the_predator_like_a_fountain(pair, angle, side):
    """Ahead of it they go ahead and outward, beside it outward and back."""
    place = np.radians(side * angle)
    pair.fishes.position[0, :2] = 240 * np.cos(place) - 100, 240 * np.sin(place)
    way = _away(pair)
    assert np.arctan2(way[1], way[0]) == pytest.approx(place + side * ASIDE_RAD, abs=1e-4)
    assert np.linalg.norm(way) == pytest.approx(1.0, abs=1e-5)


def test_they_leave_the_clear_space_about_it_most_urgently(pair):
    clear = CLEAR * pair.minds.dread[0]
    sizes = []
    for share in (1.1, 0.8, 0.4, 0.1):
        pair.fishes.position[0, 0] = -100.0 + share * clear
        sizes.append(np.linalg.norm(_away(pair)))
    assert sizes[0] == pytest.approx(1.0)
    assert (np.diff(sizes) > 0).all()
    assert sizes[-1] < 1.0 + PUSH


def test_they_keep_off_a_place_that_they_remember_and_hurry_less(pair):
    assert haste(pair.minds, 0, pair.nature) == 1.0
    pair.minds.predator[0], pair.minds.unseen[0] = NOBODY, 2.0
    np.testing.assert_allclose(_away(pair), (REMEMBERED, 0.0, 0.0), atol=1e-5)
    assert haste(pair.minds, 0, pair.nature) == pytest.approx(0.4, abs=1e-5)
    pair.minds.unseen[0] = np.inf
    np.testing.assert_array_equal(_away(pair), 0.0)


def test_stone_and_seabed_hide_a_single_fish(tank):
    pillar, rock = (200.0, 0.0, 30.0, -100.0), (-200.0, 0.0, -300.0, 30.0, 30.0, 30.0, 0.0)
    t = tank(1, pillars=[pillar], rocks=[rock])
    places = ((0, 0, -300), (150, 0, -300), (-150, 0, -300), (0, 0, -585))
    for place, hidden in zip(places, (False, True, True, True), strict=True):
        t.fishes.position[0] = place
        t.minds.schools[0] = False
        assert is_hidden(t.fishes, t.minds, 0, t.sea) == hidden
        t.minds.schools[0] = True
        assert not is_hidden(t.fishes, t.minds, 0, t.sea)


def test_a_wary_fish_hovers_broadside_to_what_it_watches(pair):
    pair.fishes.position[1] = -300.0, 20.0, -300.0
    pair.minds.threat_place[0] = pair.fishes.position[1]
    wishes = []
    for fear, schools, unseen in (
        (0.2, False, 0),
        (0.4, False, 0),
        (0.4, True, 0),
        (0.4, False, 9),
    ):
        pair.minds.mental[0, FEAR], pair.minds.schools[0] = fear, schools
        pair.minds.unseen[0] = unseen
        wishes.append(bool(pair.desire(watch_desire)[0] > 0.0))
    assert wishes == [False, True, False, False]
    pair.run(watch, 0)
    way = pair.minds.urge[0] / np.linalg.norm(pair.minds.urge[0])
    assert 0.0 < way[0] < 0.5
    assert abs(way[1]) > 0.85
    assert pair.fishes.goal_speed[0] == np.float32(HOVER)
