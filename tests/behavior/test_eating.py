"""Feeding on plankton."""

import numpy as np
import pytest

from subsea.behavior import eating
from subsea.behavior.chasing import chase, mouth_of
from subsea.behavior.picking import DARTS, DARTS_ASIDE_CM
from subsea.state import ANEMONE, BATHES, EAT, HUNGER, Clock


def test_hunger_above_the_threshold_and_something_to_eat(tank):
    t = tank(4, specks=1)
    t.minds.mental[:, HUNGER] = 0.2, 0.3, 0.3, 0.2
    t.minds.food[:] = 0, 0, -1, 0
    t.minds.intention[3] = EAT  # goes on a little longer
    np.testing.assert_array_equal(t.desire(eating.desire) > t.nature.keen, [0, 1, 0, 1])


def test_the_mouth_is_at_the_snout(tank):
    t = tank()
    np.testing.assert_allclose(mouth_of(t.fishes, 0), [7.0, 0.0, -300.0], atol=1e-5)


def test_a_far_target_is_chased_at_full_speed_and_a_near_one_slowly(tank):
    t = tank()
    speeds = []
    for far in (200.0, 25.0, 8.0):
        distance = chase(t.fishes, t.minds, 0, (far, 0.0, -300.0), (0.0, 0.0, 0.0))
        assert distance == pytest.approx(far - 7.0, abs=1e-4)
        speeds.append(t.fishes.goal_speed[0])
    assert speeds[0] == 1.0
    assert speeds[0] > speeds[1] > speeds[2] > 0
    # A moving target is intercepted.
    chase(t.fishes, t.minds, 0, (60.0, 0.0, -300.0), (0.0, 10.0, 0.0))
    assert t.minds.urge[0, 1] > 5.0


def test_a_speck_near_an_open_mouth_is_sucked_in_and_counted(tank):
    t = tank(specks=2)
    t.sea.plankton[:] = (9.5, 0.0, -300.0), (60.0, 0.0, -300.0)
    t.minds.intention[:], t.minds.target[:], t.minds.appetite[:] = EAT, 0, 5.0
    # A shut mouth draws nothing.
    eating.ingest(t.fishes, t.minds, t.sea, t.clock)
    assert t.sea.absent[0] == 0
    np.testing.assert_allclose(t.sea.plankton[0], [9.5, 0.0, -300.0])
    t.run(eating.act)
    assert t.fishes.gape[0] == 1.0
    for tick in range(1, 12):
        eating.ingest(t.fishes, t.minds, t.sea, Clock(1, tick, 0.033))
    np.testing.assert_array_equal(t.sea.absent > 0, [True, False])
    assert t.minds.eaten[0] == 1.0
    assert t.minds.last_meal[0] > 0
    assert t.minds.target[0] == -1
    low, high = eating.ABSENCE_S
    assert low <= t.sea.absent[0] <= high


def test_a_straggler_catches_up_before_it_eats(tank):
    t = tank(2, specks=1)
    t.sea.plankton[0] = 40.0, 0.0, -300.0
    t.minds.mental[1, HUNGER], t.minds.food[1] = 0.9, 0
    t.minds.schools[:], t.minds.leader[1], t.minds.leader_seen[1] = True, 0, 0.0
    t.minds.leader_place[1] = 50.0, 0.0, -300.0
    assert t.desire(eating.desire)[1] > 0.0
    t.minds.leader_place[1] = 400.0, 0.0, -300.0
    assert t.desire(eating.desire)[1] == 0.0
    t.minds.neighbour[1] = 0  # in company
    assert t.desire(eating.desire)[1] > 0.0


def test_a_clownfish_picks_plankton_above_its_anemone(tank):
    t = tank(2)
    sea = t.sea._replace(
        site_kind=np.array([ANEMONE], np.uint8),
        site_place=np.array([[30.0, 0.0, -330.0]], np.float32),
    )
    t = t._replace(sea=sea)
    t.minds.ways[:], t.minds.cover[:] = (BATHES, 0), (0, -1)
    t.minds.food[:], t.minds.target[:] = -1, -1
    t.minds.mental[:, HUNGER] = 0.6
    assert (t.desire(eating.desire) > 0.0).tolist() == [True, False]
    t.minds.appetite[:], t.minds.digestion[:], t.minds.pause[:] = 2.0, 0.0067, 1.0
    places = set()
    for tick in range(1, 400, 20):
        t.at(tick).run(eating.act, 0)
        spot = t.minds.urge[0] + t.fishes.position[0] + [7.0, 0.0, 0.0]
        assert np.hypot(*(spot[:2] - [30.0, 0.0])) <= DARTS_ASIDE_CM + 1e-3
        assert spot[2] > -330.0
        places.add(tuple(np.round(spot)))
        assert t.fishes.goal_speed[0] <= DARTS + 1e-6
    assert len(places) > 5
    assert t.minds.eaten[0] > 0.0
