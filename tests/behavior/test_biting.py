"""Approach to the bait, the catch, and landing."""

import numpy as np
import pytest

from subsea.behavior import biting, eating
from subsea.behavior.biting import BITE_BL, FOLLOWS, OUT_BL, TEMPTING, YANK_CM_S, bite
from subsea.behavior.intention import choose_intention
from subsea.behavior.table import BEHAVIORS, TABLE
from subsea.state import BAIT, EAT, HANGING, HOOKED, HUNGER, NOBODY, PREDATOR, SINKING, STOWED

RISE = 30.0
BAITED = np.array([0.0, 0.0, -300.0])


def _tank(tank, *places):
    """Hungry fishes whose mouths are at places relative to a bait that hangs in the middle."""
    one = tank(len(places), specks=1)
    one.sea.tackle[:] = 0.0, 0.0, 300.0, RISE, 0.0
    one.sea.hook[:] = BAITED
    one.sea.catch[:] = HANGING, NOBODY
    one.fishes.position[:] = BAITED + np.array(places) - (one.fishes.snout[0], 0, 0)
    one.minds.mental[:, HUNGER] = 0.8
    return one


def test_the_hungry_come_for_a_bait_in_reach(tank):
    one = _tank(tank, (-200.0, 0, 0), (-599.0, 0, 0), (-601.0, 0, 0))
    assert (one.desire(eating.desire) > 0).tolist() == [True, True, False]
    one.minds.mental[0, HUNGER] = 0.5 * one.nature.keen
    one.minds.kind[1] = PREDATOR
    assert not one.desire(eating.desire).any()


@pytest.mark.parametrize(("state", "depth"), [(STOWED, 300), (HOOKED, 300), (SINKING, 2)])
def test_a_bait_that_is_bitten_or_not_yet_in_the_water_tempts_nobody(tank, state, depth):
    one = _tank(tank, (-100.0, 0, 0))
    one.sea.catch[0] = state
    one.sea.hook[2] = -depth
    assert one.desire(eating.desire)[0] == 0


def test_a_speck_that_is_much_nearer_is_preferred(tank):
    one = _tank(tank, (-200.0, 0, 0))
    one.sea.plankton[0] = one.fishes.position[0] + (0, 20, 0)
    one.minds.food[0] = one.minds.target[0] = 0
    for distance, target in ((200 / TEMPTING * 0.9, 0), (200 / TEMPTING * 1.1, BAIT)):
        one.minds.target[0], one.minds.food_distance[0] = 0, distance
        one.run(eating.act)
        assert one.minds.target[0] == target
    # Straight to the bait, the mouth still shut.
    assert one.minds.urge[0] == pytest.approx([200, 0, 0])
    assert one.fishes.gape[0] == 0
    one.fishes.position[0, 0] += 195.0
    one.run(eating.act)
    assert one.fishes.gape[0] == 1


def test_a_bait_that_sinks_is_headed_off(tank):
    one = _tank(tank, (-50.0, 0, 0))
    one.run(eating.act)
    assert one.minds.urge[0, 2] == pytest.approx(0)
    one.sea.catch[0] = SINKING
    one.run(eating.act)
    assert one.minds.urge[0, 2] < -30


def test_the_first_to_bite_is_caught_but_not_from_afar(tank):
    near = BITE_BL * 20.0
    one = _tank(tank, (-1.1 * near, 0, 0))
    one.minds.intention[0], one.minds.target[0] = EAT, BAIT
    bite(one.fishes, one.minds, one.sea, one.clock)
    assert one.sea.catch[0] == HANGING
    one = _tank(tank, (-0.9 * near, 0, 0), (0, 0.5 * near, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0))
    one.minds.intention[:4] = EAT
    one.minds.target[:] = BAIT, BAIT, 0, BAIT, BAIT
    one.fishes.alive[3] = False
    # The caught fish led a school.
    one.minds.leader[2], one.minds.leads[1] = 1, True
    bite(one.fishes, one.minds, one.sea, one.clock)
    assert one.sea.catch.tolist() == [HOOKED, 1]
    assert one.minds.leader[2] == NOBODY
    assert not one.minds.leads[1]


@pytest.mark.parametrize("gap", [4.0, 60.0])
def test_the_catch_is_drawn_along(tank, gap):
    one = _tank(tank, (0, gap, 0), (0, 0, 0))
    one.sea.catch[:] = HOOKED, 0
    bite(one.fishes, one.minds, one.sea, one.clock)
    speed = min(FOLLOWS * gap, YANK_CM_S)
    assert one.fishes.drift[0] == pytest.approx([0, -speed, RISE], abs=1e-4)
    assert (one.fishes.drift[1] == 0).all()


def test_the_catch_is_gone_once_it_is_above_the_surface(tank):
    one = _tank(tank, (0, 0, 0))
    one.sea.catch[:] = HOOKED, 0
    one.fishes.position[0, 2] = 0.9 * OUT_BL * 20
    bite(one.fishes, one.minds, one.sea, one.clock)
    assert one.fishes.alive[0]
    one.fishes.position[0, 2] = 1.1 * OUT_BL * 20
    bite(one.fishes, one.minds, one.sea, one.clock)
    assert not one.fishes.alive[0]
    assert one.sea.catch.tolist() == [HOOKED, NOBODY]


def test_struggling_comes_before_all_else(tank):
    one = _tank(tank, (0, 0, 0), (0, 0, 0))
    one.sea.catch[:] = HOOKED, 1
    one.minds.desire[:] = 1.0
    for row, code in enumerate(TABLE.behavior):
        if BEHAVIORS[code].name == "struggle":
            biting.hooked_desire(np.arange(2), *one, one.minds.desire[row])
    choose_intention(np.arange(2), one.minds, one.nature, TABLE.level, TABLE.behavior, TABLE.tires)
    assert [BEHAVIORS[code].name for code in one.minds.intention] == ["avoid", "struggle"]


def test_it_struggles_downward_now_this_way_now_that(tank):
    one = _tank(tank, (0, 0, 0))
    ways = []
    for tick in range(300):
        one.at(tick).run(biting.struggle)
        assert one.minds.urge[0, 2] < 0
        assert one.fishes.goal_speed[0] == 1
        ways.append(np.arctan2(one.minds.urge[0, 1], one.minds.urge[0, 0]))
    changes = np.count_nonzero(np.diff(ways))
    assert changes == 299 // biting.HOLD_TICKS
    assert np.ptp(ways) > np.pi
