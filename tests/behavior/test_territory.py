"""Residents drive intruders off."""

import numpy as np
import pytest

from subsea.behavior import territory
from subsea.behavior.table import INTENTIONS
from subsea.perception.crowd import crowd_of
from subsea.perception.territory import FOLLOWS, KNOWN_S, NEIGHBOURS, find_intruders
from subsea.state import APPROACHING, GUARD, NOBODY, PREDATOR, WANDER, YIELD


def met(tank, *places):
    """A resident at home at the origin of the tank, and others of another species."""
    t = tank(1 + len(places))
    t.fishes.species[1:] = 1
    for k, place in enumerate(places, start=1):
        t.fishes.position[k] = place
    t.minds.home[0], t.minds.territory[0] = t.fishes.position[0], 60.0
    return t


def seen(t):
    find_intruders(np.arange(len(t.minds.home)), t.fishes, t.minds, crowd_of(t.fishes))
    return int(t.minds.intruder[0])


def test_the_codes_are_those_of_the_table():
    assert (INTENTIONS[GUARD], INTENTIONS[YIELD]) == ("guard", "yield")


def test_the_nearest_fish_of_another_species_in_the_territory_intrudes(tank):
    t = met(tank, (50.0, 0.0, -300.0), (30.0, 0.0, -300.0), (200.0, 0.0, -300.0))
    assert seen(t) == 2
    t.minds.intruder[0] = NOBODY
    t.fishes.species[2] = 0  # one of its own
    assert seen(t) == 1
    for change in ("schools", "courtship", "kind"):
        t.minds.intruder[0] = NOBODY
        array, before = getattr(t.minds, change), getattr(t.minds, change)[1]
        array[1] = {"schools": True, "courtship": APPROACHING, "kind": PREDATOR}[change]
        assert seen(t) == NOBODY, change
        array[1] = before
    t.fishes.length[1] = 100.0
    assert seen(t) == NOBODY


def test_one_that_is_followed_counts_until_it_is_far_off(tank):
    t = met(tank, (50.0, 0.0, -300.0))
    assert seen(t) == 1
    t.fishes.position[1, 0] = 0.5 * (1.0 + FOLLOWS) * 60.0
    assert seen(t) == 1
    t.fishes.position[1, 0] = FOLLOWS * 60.0 + 5.0
    assert seen(t) == NOBODY


def test_a_neighbour_that_was_chased_off_lately_is_tolerated_farther_out(tank):
    assert KNOWN_S == territory.REMEMBERS_S
    t = met(tank, (50.0, 0.0, -300.0))
    t.minds.chaser[1], t.minds.chased[1] = 0, territory.REMEMBERS_S + 1.0
    assert seen(t) == 1  # it is still chased
    t.minds.chased[1] = territory.REMEMBERS_S - 1.0
    assert seen(t) == NOBODY
    t.fishes.position[1, 0] = 0.8 * NEIGHBOURS * 60.0
    assert seen(t) == 1
    t.minds.chaser[1], t.fishes.position[1, 0] = 2, 50.0  # by another resident
    assert seen(t) == 1


def test_a_resident_shows_itself_before_it_chases(tank):
    t = met(tank, (50.0, 0.0, -300.0))
    t.fishes.burst[:], t.minds.intruder[0] = 1.4, 1
    assert t.desire(territory.desire)[0] == pytest.approx(territory.ZEAL)
    t.minds.held[0] = 0.5 * territory.DISPLAY_S
    t.run(territory.act, 0)
    assert t.fishes.goal_speed[0] == pytest.approx(territory.SHOWS)
    assert t.minds.chaser[1] == NOBODY
    t.minds.held[0] = 1.1 * territory.DISPLAY_S
    t.run(territory.act, 0)
    assert t.fishes.goal_speed[0] == pytest.approx(1.0)  # and no burst
    assert t.minds.urge[0, 0] > 0.0
    assert t.minds.chaser[1] == 0


def test_a_resident_gives_a_chase_up_and_rests_after_it(tank):
    t = met(tank, (50.0, 0.0, -300.0))
    t.minds.intruder[0], t.minds.intention[0] = 1, GUARD
    t.minds.fatigue[GUARD, 0], t.minds.held[0] = 3.0, 2.0
    assert t.desire(territory.desire)[0] > 0.0
    t.minds.held[0] = territory.DISPLAY_S + territory.CHASES_S + 0.1
    assert t.desire(territory.desire)[0] == 0.0
    t.minds.intention[0] = WANDER
    assert t.desire(territory.desire)[0] == 0.0
    t.minds.fatigue[GUARD, 0] = 0.0
    assert t.desire(territory.desire)[0] > 0.0


def test_the_intruder_swims_away_for_a_while(tank):
    t = met(tank, (50.0, 0.0, -300.0))
    t.minds.chaser[1], t.minds.chased[1] = 0, territory.LEAVES_S + territory.REMEMBERS_S
    assert (t.desire(territory.yielding_desire) > 0.0).tolist() == [False, True]
    t.run(territory.give_way, 1)
    assert t.minds.urge[1, 0] > 0.0
    assert t.fishes.goal_speed[1] == pytest.approx(territory.FLEES)
    t.minds.pause[:] = territory.LEAVES_S + 0.1
    assert not t.desire(territory.yielding_desire).any()
    assert t.minds.chaser[1] == 0  # it remembers
    t.minds.pause[:] = territory.REMEMBERS_S
    t.desire(territory.yielding_desire)
    assert t.minds.chaser[1] == NOBODY
