"""Fishes feed on stone: when, how they lie, and what a bite does."""

import numpy as np
import pytest

from subsea.behavior import eating, grazing
from subsea.behavior.table import INTENTIONS
from subsea.geometry.rotation import about, multiply, quaternion
from subsea.geometry.vector import norm
from subsea.state import GRAZE, HUNGER, TURF


def fed(tank, n=1, **nature):
    """A tank with one place of turf under the snouts of its fishes."""
    t = tank(n, **nature)
    place = np.array([[7.0, 0.0, -300.0]], np.float32)
    sea = t.sea._replace(
        site_kind=np.array([TURF], np.uint8), site_place=place,
        site_normal=np.array([[0.0, 0.0, 1.0]], np.float32),
        site_growth=np.array([-1], np.int32), site_depth=np.zeros(1, np.float32),
        stock=np.ones(1, np.float32),
    )  # fmt: skip
    t.minds.diet[:], t.minds.site[:] = 1 << TURF, 0
    t.minds.appetite[:], t.minds.digestion[:] = 3.0, 0.0067
    return t._replace(sea=sea)


def test_its_code_is_that_of_the_table():
    assert INTENTIONS[GRAZE] == "graze"


def test_a_hungry_fish_with_food_on_stone_grazes_and_leaves_plankton_alone(tank):
    t = fed(tank, 3)
    t.minds.mental[:, HUNGER] = 0.6, 0.0, 0.6
    t.minds.site[1:] = -1
    assert t.desire(grazing.desire) == pytest.approx([0.6, 0.0, 0.0])
    specks = t._replace(
        sea=t.sea._replace(
            plankton=np.array([[20.0, 0.0, -300.0]], np.float32), absent=np.zeros(1, np.float32)
        )
    )
    t.minds.food[:] = 0
    assert (specks.desire(eating.desire) > 0.0).tolist() == [False, False, True]


@pytest.mark.parametrize(
    ("normal", "least", "most"), [((0, 0, 1), 45, 65), ((-1, 0, 0), 20, 50), ((0, 1, 0), 15, 60)]
)
def test_it_lies_nose_down_against_any_surface(normal, least, most):
    lie = grazing.attitude((1.0, 0.0, 0.0), tuple(np.float32(normal)))
    assert norm(lie) == pytest.approx(1.0)
    assert np.dot(lie, normal) < -0.5  # into the surface
    assert least <= -np.degrees(np.arcsin(lie[2])) <= most


def test_a_bite_empties_the_place_and_feeds_the_fish(tank):
    t = fed(tank).at(1000)
    t.minds.intention[:], t.fishes.close[:] = GRAZE, True
    t.minds.eaten[:], t.minds.last_meal[:] = 1.0, 0.0
    t.minds.fatigue[GRAZE] = 20.0
    grazing.bite(t.fishes, t.minds, t.sea, t.clock)
    assert t.sea.stock.tolist() == pytest.approx([1.0 - grazing.BITE])
    left = 1.0 - 0.0067 * 33.0
    assert t.minds.eaten[0] == pytest.approx(left + grazing.BITE_S * 0.0067 * 3.0, rel=1e-5)
    assert t.minds.last_meal[0] == pytest.approx(33.0)
    assert t.minds.fatigue[GRAZE, 0] == 0.0
    low, high = grazing.PAUSE_S
    assert low <= t.minds.peck[0] <= high
    assert t.sea.stock[0] > grazing.BARE
    grazing.bite(t.fishes, t.minds, t.sea, t.clock)
    assert t.sea.stock.tolist() == pytest.approx([1.0 - grazing.BITE])  # it chews


def test_it_bites_only_what_its_snout_reaches_and_leaves_a_bare_place(tank):
    t = fed(tank)
    t.minds.intention[:], t.fishes.close[:] = GRAZE, True
    t.fishes.position[:, 0] = 4.0
    grazing.bite(t.fishes, t.minds, t.sea, t.clock)
    assert t.sea.stock[0] == 1.0
    t.fishes.position[:, 0], t.sea.stock[0] = 0.5, grazing.BARE + 0.5 * grazing.BITE
    grazing.bite(t.fishes, t.minds, t.sea, t.clock)
    assert t.sea.stock[0] == pytest.approx(grazing.BARE - 0.5 * grazing.BITE)
    assert t.minds.site[0] == -1


def test_it_slows_down_before_its_food_and_moves_by_its_fins_there(tank):
    t = fed(tank)
    t.fishes.position[:, 0] = -22.0
    t.run(grazing.act)
    assert t.fishes.close[0]
    assert t.fishes.shell[0] == pytest.approx(grazing.SLACK_CM)
    near = float(t.fishes.goal_speed[0])
    assert 0.0 < near <= grazing.ARRIVES
    t.fishes.position[:] = -3.0, 0.0, -295.0
    t.run(grazing.act)
    assert t.fishes.goal_speed[0] == 0.0
    t.fishes.position[:, 0] = -200.0
    t.fishes.close[:] = False
    t.run(grazing.act)
    assert not t.fishes.close[0]
    assert t.fishes.goal_speed[0] > near


def test_a_hovering_fish_strikes_when_it_is_aimed_and_falls_back_after_the_bite(tank):
    t = fed(tank)
    t.minds.intention[:], t.fishes.close[:] = GRAZE, True
    t.fishes.position[:] = -2.0, 0.0, -300.0  # its snout is 2 cm before the food

    def sculls():
        t.fishes.drift[:] = 0.0
        grazing.hold(t.fishes, t.minds, t.sea)
        return t.fishes.drift[0].copy()

    assert sculls()[2] > 0.0  # it lies level: back to the place over its food
    down = np.radians(-53.0)
    level = quaternion(t.fishes.orientation[0].astype(np.float64))
    t.fishes.orientation[0] = multiply(
        level, about(0.0, 0.0, 1.0, down)
    )  # its snout is over the food
    snout = 7.0 * np.array([np.cos(down), 0.0, np.sin(down)])
    t.fishes.position[0] = np.array([7.0, 0.0, -298.0]) - snout
    assert sculls()[2] < 0.0
    t.minds.peck[:], t.fishes.identity[:] = 0.5 * grazing.PAUSE_S[0], 0.0
    assert sculls()[2] > 0.0
    assert np.linalg.norm(sculls()) <= grazing.SCULLS_BL_S * t.fishes.length[0] + 1e-3
    t.minds.intention[:] = GRAZE + 1
    assert not sculls().any()


def test_it_gives_a_place_up_that_it_cannot_reach(tank):
    t = fed(tank)
    t.fishes.position[:, 0], t.minds.pause[:] = -10.0, grazing.GIVES_UP_S + 0.1
    t.run(grazing.act)
    assert t.minds.site[0] == -1
