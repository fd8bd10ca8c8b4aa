"""Cleaners hold a station, and clients pose before them."""

import numpy as np
import pytest

from subsea.behavior import cleaning
from subsea.behavior.courtship import ease_display
from subsea.behavior.table import INTENTIONS
from subsea.geometry.vector import norm
from subsea.state import CLEAN, CLEANS, HIDES, NOBODY, POSE
from subsea.state.wants import ITCH_BEGINS, ITCH_ENDS


def station(tank):
    """A cleaner at its station in the middle, and a client that poses a little aside."""
    t = tank(2)
    t.minds.ways[:] = CLEANS, HIDES
    t.minds.home[:] = t.fishes.position
    t.minds.cleaner[1], t.minds.client[0] = 0, 1
    t.minds.digestion[:], t.minds.appetite[:] = 0.0067, 3.0
    t.minds.itch[1] = 1.0
    return t


def test_the_codes_are_those_of_the_table():
    assert (INTENTIONS[POSE], INTENTIONS[CLEAN]) == ("pose", "clean")


def test_an_itch_grows_until_a_fish_goes_to_a_cleaner(tank):
    t = station(tank)
    t.minds.itch[1] = ITCH_BEGINS - 0.01
    assert t.desire(cleaning.posing_desire)[1] == 0.0
    t.minds.pause[:] = 0.02 * cleaning.ITCH_S[1]
    assert t.desire(cleaning.posing_desire)[1] == pytest.approx(cleaning.POSING)
    t.minds.cleaner[1] = NOBODY
    assert t.desire(cleaning.posing_desire)[1] == 0.0


def test_a_fish_waits_elsewhere_while_another_one_is_cleaned(tank):
    t = station(tank)
    t.minds.client[0] = NOBODY
    assert t.desire(cleaning.posing_desire)[1] > 0.0
    t.minds.client[0] = 0
    assert t.desire(cleaning.posing_desire)[1] == 0.0
    t.minds.intention[1] = POSE  # it has come before
    assert t.desire(cleaning.posing_desire)[1] > 0.0


def test_a_client_swims_to_its_place_then_stands_with_its_head_up_and_fins_spread(tank):
    t = station(tank)
    t.fishes.position[1] = 200.0, 0.0, -300.0
    t.run(cleaning.pose, 1)
    assert t.fishes.goal_speed[1] > 0.3
    place = (cleaning.RING_CM + cleaning.RING_BL * 20.0) * np.array([1.0, 0.0, 0.3])
    t.fishes.position[1] = t.minds.home[0] + place
    t.run(cleaning.pose, 1)
    assert t.fishes.goal_speed[1] == 0.0
    urge = t.minds.urge[1]
    assert np.degrees(np.arctan2(urge[2], np.hypot(urge[0], urge[1]))) == pytest.approx(48.0)
    t.minds.intention[1] = POSE
    ease_display(np.arange(2), t.fishes, t.minds, t.sea, t.clock)
    assert t.fishes.raised.tolist() == [0.0, 1.0]


def test_a_client_that_is_not_cleaned_gives_up(tank):
    t = station(tank)
    t.minds.client[0], t.minds.held[1] = NOBODY, cleaning.WAITS_S + 1.0
    t.run(cleaning.pose, 1)
    t.minds.intention[1] = POSE
    assert t.desire(cleaning.posing_desire)[1] == 0.0


def test_a_cleaner_prefers_a_client_to_its_station(tank):
    t = station(tank)
    assert t.desire(cleaning.desire)[0] == pytest.approx(cleaning.CLEANING)
    t.minds.client[0] = NOBODY
    assert t.desire(cleaning.desire)[0] == 0.0
    holds = [t.at(tick).desire(cleaning.holding_desire)[0] > 0.0 for tick in range(0, 9000, 30)]
    assert np.mean(holds) == pytest.approx(cleaning.HOLDS, abs=0.1)


def test_it_picks_at_the_skin_until_the_itch_is_gone_or_the_client_jolts(tank):
    t = station(tank)
    t.fishes.position[1] = 10.0, 0.0, -300.0
    before, eaten = float(t.minds.itch[1]), float(t.minds.eaten[0])
    t.run(cleaning.act, 0)
    assert t.minds.itch[1] < before
    assert t.minds.eaten[0] > eaten
    jolts = 0
    for tick in range(3000):
        t.minds.itch[1] = 1.0
        t.at(tick).run(cleaning.act, 0)
        jolts += t.minds.itch[1] < ITCH_ENDS
    expected = 3000 * t.clock.dt / cleaning.JOLT_S
    assert 0.5 * expected < jolts < 2.0 * expected


def test_a_cleaner_that_is_far_away_comes_and_cleans_nobody(tank):
    t = station(tank)
    t.fishes.position[1] = 150.0, 0.0, -300.0
    t.run(cleaning.act, 0)
    assert t.minds.itch[1] == 1.0
    assert norm(tuple(t.minds.urge[0].tolist())) > 0.0
    assert t.minds.urge[0, 0] > 0.0


def test_a_cleaner_holds_a_station_only_where_it_likes_the_water(tank):
    t = station(tank)
    t.fishes.identity[0] = 0.0  # at the beginning of its cycle
    assert t.desire(cleaning.holding_desire)[0] == pytest.approx(cleaning.HOLDING)
    t.minds.comfort[0] = 350.0, 600.0
    assert t.desire(cleaning.holding_desire)[0] == 0.0
