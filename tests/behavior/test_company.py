"""Fishes keep off those that they dislike, and stay near those that they like."""

import numpy as np
import pytest

from subsea.behavior import company, curious, death, eating, escaping, mating, schooling, wandering
from subsea.behavior.intention import choose_intention
from subsea.behavior.table import INTENTIONS, TABLE
from subsea.perception.focusser import set_targets
from subsea.state import EAT, MATE, NOBODY, PREDATOR, PREY, SPAWNING, SUBMARINE
from subsea.state.feelings import feel, feeling_for


def _towards(t, i, place):
    """Cosine of the angle between the urge of fish i and the way to a place."""
    way = np.asarray(place, float) - t.fishes.position[i]
    urge = t.minds.urge[i]
    return urge @ way / (np.linalg.norm(way) * np.linalg.norm(urge))


def test_a_disliked_fish_is_kept_off_and_a_stranger_is_not(tank):
    t = tank(4)
    t.fishes.position[1:] = (60.0, 40.0, -300.0), (60.0, -40.0, -300.0), (600.0, 0.0, -300.0)
    feel(t.minds, 0, 1, -0.8)
    feel(t.minds, 2, 3, -0.8)  # far away
    assert (t.desire(company.shun_desire) > 0.0).tolist() == [True, False, False, False]
    t.run(company.shun, 0)
    assert _towards(t, 0, t.fishes.position[1]) < -0.5
    t.fishes.alive[1] = False
    death.forget(t.minds, 1)
    assert not t.desire(company.shun_desire).any()


def test_prey_leaves_predators_to_fear(tank):
    t = tank(2)
    t.minds.kind[:] = PREY, PREDATOR
    t.fishes.position[1] = 60.0, 40.0, -300.0
    feel(t.minds, 0, 1, -1.0)
    assert not t.desire(company.shun_desire).any()


def test_a_fish_stays_near_one_that_it_likes(tank):
    t = tank(3)
    t.fishes.position[1:] = (0.0, 200.0, -300.0), (0.0, 700.0, -300.0)
    feel(t.minds, 0, 1, 0.9)
    feel(t.minds, 2, 1, 0.5)  # out of call
    misses = t.desire(company.stay_desire)
    assert (misses > 0.0).tolist() == [True, False, False]
    assert misses[0] > t.desire(wandering.desire)[0]
    t.run(company.stay, 0)
    assert _towards(t, 0, t.fishes.position[1]) > 0.9
    t.fishes.position[1] = 0.0, 40.0, -300.0
    assert not t.desire(company.stay_desire).any()


def test_dislike_is_stronger_than_calm_schooling(tank):
    t = tank(3)
    t.minds.schools[:] = True
    t.minds.leads[0], t.minds.school_size[:] = True, 3.0
    t.minds.neighbour[0, :2] = 1, 2
    t.fishes.position[1] = 0.0, 50.0, -300.0
    feel(t.minds, 0, 1, -0.4)
    assert 0.0 < t.desire(schooling.desire)[0] < t.desire(company.shun_desire)[0]


def test_only_the_chased_fish_bears_a_grudge(tank):
    t = tank(3)
    t.minds.kind[:] = PREY, PREY, PREDATOR
    t.fishes.position[:2, 1] = 0.0, 30.0
    t.fishes.position[2] = -90.0, 0.0, -300.0
    t.fishes.velocity[2] = 120.0, 0.0, 0.0
    t.minds.predator[:2] = 2
    t.minds.intention[2], t.minds.target[2] = EAT, 0
    for tick in range(60):
        t.at(tick).run(escaping.act, 0, 1)
    assert -0.6 < feeling_for(t.minds, 0, 2) < -0.2
    assert feeling_for(t.minds, 1, 2) == 0.0


def test_a_pair_that_spawned_likes_each_other_and_courts_again_first(tank):
    t = tank(4)
    t.minds.male[:] = True, False, False, False
    t.fishes.position[1:] = (150.0, 0.0, -300.0), (60.0, 0.0, -300.0), (80.0, 30.0, -300.0)
    t.minds.partner[:2], t.minds.courtship[:2] = (1, 0), SPAWNING
    mating.enter_next_state(np.array([0]), t.fishes, t.minds, t.sea, t.clock)
    assert feeling_for(t.minds, 0, 1) == feeling_for(t.minds, 1, 0) == pytest.approx(mating.BONDS)
    t.minds.shunned[:] = NOBODY
    t.minds.intention[0], t.minds.mates[0] = MATE, (2, 3, 1)
    set_targets(np.array([0]), t.fishes, t.minds, t.sea, t.nature)
    assert t.minds.target[0] == 1
    t.minds.liked[:], t.minds.liking[:], t.minds.target[0] = NOBODY, 0.0, -1
    set_targets(np.array([0]), t.fishes, t.minds, t.sea, t.nature)
    assert t.minds.target[0] == 2


def test_fishes_fed_beside_the_submarine_come_to_it(tank):
    t = tank(2, specks=2)
    t.minds.kind[:] = PREY
    t.sea.submarine[:3] = 200.0, 0.0, -300.0
    assert not t.desire(curious.desire).any()
    t.fishes.position[1] = -400.0, 0.0, -300.0  # it eats far away
    for _ in range(3):
        t.sea.absent[:] = 0.0
        t.minds.intention[:], t.minds.target[:] = EAT, (0, 1)
        t.fishes.gape[:] = 1.0
        t.sea.plankton[:] = t.fishes.position + (7.0, 0.0, 0.0)
        eating.ingest(t.fishes, t.minds, t.sea, t.clock)
    assert t.minds.eaten.tolist() == [3.0, 3.0]
    assert feeling_for(t.minds, 0, SUBMARINE) == pytest.approx(3 * eating.FED)
    assert feeling_for(t.minds, 1, SUBMARINE) == 0.0
    assert t.desire(curious.desire)[0] > 0.0


def test_the_intention_generator_knows_both_behaviors(tank):
    t = tank(2)
    for name, desire in (("shun", company.shun_desire), ("stay", company.stay_desire)):
        t.minds.liked[:], t.minds.liking[:] = NOBODY, 0.0
        t.fishes.position[1] = 0.0, 100.0, -300.0
        feel(t.minds, 0, 1, -0.9 if name == "shun" else 0.9)
        t.minds.desire[:], t.minds.held[:] = 0.0, np.inf  # no intention is too new to change
        row = [code == INTENTIONS.index(name) for code in TABLE.behavior].index(True)
        t.minds.desire[row] = t.desire(desire)
        levels = TABLE.level, TABLE.behavior, TABLE.tires
        choose_intention(np.arange(2), t.minds, t.nature, *levels)
        assert INTENTIONS[t.minds.intention[0]] == name
