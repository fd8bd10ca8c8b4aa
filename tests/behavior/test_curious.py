"""Pacifists that come to see the submarine."""

import numpy as np
import pytest

from subsea.behavior import curious
from subsea.behavior.curious import FORGETS, FRESH_S, SATED_S, WATCH_CM, place_before
from subsea.behavior.intention import choose_intention
from subsea.behavior.table import BEHAVIORS, TABLE
from subsea.state import CURIOUS, PREY, WANDER


def _tank(tank, n=1, away=200.0):
    """Pacifists that see the submarine `away` cm ahead; it looks at them."""
    one = tank(n)
    one.sea.submarine[:] = away, 0.0, -300.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0
    return one


def test_its_code_is_its_place_in_the_table():
    assert BEHAVIORS[CURIOUS].routine is curious.act
    assert BEHAVIORS[CURIOUS].tires


def test_pacifists_that_see_the_submarine_are_curious(tank):
    one = _tank(tank)
    assert one.desire(curious.desire)[0] > 0
    one.minds.kind[0] = PREY
    assert one.desire(curious.desire)[0] == 0
    one.minds.kind[0] = 0
    one.sea.submarine[0] = -200.0  # right behind it
    assert one.desire(curious.desire)[0] == 0
    one.sea.submarine[:2] = -120.0, 160.0
    assert one.desire(curious.desire)[0] > 0
    one.sea.submarine[:2] = 1.01 * one.nature.curiosity_cm, 0.0
    assert one.desire(curious.desire)[0] == 0


def test_it_looks_its_fill_and_comes_back_a_minute_later(tank):
    """The intention generator alternates: watching, another behavior for a while, watching."""
    one = _tank(tank, n=3)
    one.fishes.identity[:] = 0.0, 0.5, 0.99
    who, looks = np.arange(3), []
    one.minds.pause[:] = 0.1
    for _ in range(2400):
        one.minds.desire[:] = 0.0
        for row, code in enumerate(TABLE.behavior):
            if code == WANDER:
                one.minds.desire[row] = 0.01
            if code == CURIOUS:
                curious.desire(who, *one, one.minds.desire[row])
        choose_intention(who, one.minds, one.nature, TABLE.level, TABLE.behavior, TABLE.tires)
        looks.append(one.minds.intention == CURIOUS)
    looks = np.array(looks)
    for i, identity in enumerate(one.fishes.identity):
        turns = np.flatnonzero(np.diff(looks[:, i].astype(int)))
        look = SATED_S[0] + (SATED_S[1] - SATED_S[0]) * identity
        assert 0.1 * turns[0] == pytest.approx(look, abs=0.4)
        assert 0.1 * (turns[1] - turns[0]) == pytest.approx((look - FRESH_S) / FORGETS, abs=1.0)
        assert looks[turns[1] + 1, i]


def test_it_comes_before_the_window_then_hovers_and_faces_it(tank):
    one = _tank(tank, away=300.0)
    one.fishes.identity[:] = 0.5
    one.run(curious.act)
    assert one.minds.urge[0, 0] > 0.9 * np.linalg.norm(one.minds.urge[0])
    assert one.fishes.goal_speed[0] == 1
    spot = one.sea.submarine[:3] + place_before(one.sea, *np.float32([20.0, 0.5]))
    one.fishes.position[0] = spot
    one.run(curious.act)
    toward = one.sea.submarine[:3] - spot
    np.testing.assert_allclose(one.minds.urge[0], toward, atol=1e-3)
    assert 0 <= one.fishes.goal_speed[0] < 0.1
    one.fishes.position[0] = one.sea.submarine[:3] - (0.6 * WATCH_CM, 0, 0)
    one.run(curious.act)
    assert one.fishes.goal_speed[0] < 0


def test_places_lie_before_the_window_apart_from_each_other(tank):
    one = _tank(tank)
    places = np.array([place_before(one.sea, *np.float32([20.0, k / 20])) for k in range(20)])
    off = np.linalg.norm(places, axis=1)
    assert (off > WATCH_CM).all()
    assert (places @ one.sea.submarine[6:] > 0.75 * off).all()
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2) + 1e3 * np.eye(20)
    assert gaps.min() > 10
