"""Hunger, libido and fear against Tu's formulas (§7.4)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior.mental_state import stimulus, update_mental_state
from subsea.state import FEAR, HUNGER, LIBIDO, PACIFIST, PREDATOR, PREY, Clock

ONE = np.zeros(1, np.int64)
TICK = 0.033


def _feel(tank, seconds=0.0, hour=18.0, day_libido=0.1, **minds):
    t = tank(day_libido=day_libido)
    t.sea.sky[0] = hour
    for name, value in minds.items():
        getattr(t.minds, name)[:] = value
    clock = Clock(1, round(seconds / TICK), TICK)
    update_mental_state(ONE, t.fishes, t.minds, t.sea, t.nature, clock)
    return t.minds.mental[0], t.minds


@given(st.floats(0.5, 1000))
def test_a_stimulus_is_a_soft_step(distance):
    s = 1 / distance
    if s <= 0.05:
        expected = 0.0
    elif s >= 0.2:
        expected = 1.0
    else:
        expected = (s - 0.05) / (2 * 0.2 - 0.05 - s)
    assert stimulus(distance, 0.05, 0.2) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("seconds", [3.3, 33.0, 99.0])
@pytest.mark.parametrize(("eaten", "appetite"), [(0, 5), (3, 5), (5, 5), (9, 5)])
def test_hunger_grows_as_a_meal_is_digested(tank, seconds, eaten, appetite):
    mental, _ = _feel(tank, seconds, eaten=eaten, appetite=appetite, digestion=0.0067)
    expected = 1 - eaten * (1 - 0.0067 * seconds) / appetite
    assert mental[HUNGER] == pytest.approx(np.clip(expected, 0, 1), abs=1e-4)


def test_food_near_by_tempts_but_not_one_that_is_more_than_full(tank):
    state = {"digestion": 0.0067, "appetite": 4.0, "food_distance": 10.0}
    tempted, _ = _feel(tank, 0.0, eaten=4.0, **state)
    assert tempted[HUNGER] == pytest.approx(0.8 * (0.1 - 0.05) / (0.4 - 0.05 - 0.1), abs=1e-5)
    full, _ = _feel(tank, 0.0, eaten=8.0, **state)
    assert full[HUNGER] == 0.0


def test_digested_meals_are_forgotten(tank):
    _, minds = _feel(tank, 151.0, eaten=8.0, appetite=4.0, digestion=0.0067)
    assert minds.eaten[0] == 0.0
    _, minds = _feel(tank, 140.0, eaten=8.0, appetite=4.0, digestion=0.0067)
    assert minds.eaten[0] == 8.0


@pytest.mark.parametrize("eaten", [2.0, 4.0])
def test_libido_grows_with_time_unless_the_fish_is_hungry(tank, eaten):
    mental, _ = _feel(
        tank, 13.2, kind=PACIFIST, libido_rate=0.025, eaten=eaten, appetite=4.0, digestion=0.0
    )
    assert mental[LIBIDO] == pytest.approx(0.025 * 13.2 * eaten / 4.0, abs=1e-4)


def test_a_mate_near_by_adds_to_libido(tank):
    mental, _ = _feel(tank, eaten=4.0, appetite=4.0, mate_distance=20.0)
    assert mental[LIBIDO] == pytest.approx(0.5 * (0.05 - 0.025) / (0.2 - 0.025 - 0.05), abs=1e-5)


@pytest.mark.parametrize("menaces", [0.0, 0.4, 1.7])
def test_only_prey_fear_and_only_pacifists_court(tank, menaces):
    for kind in (PACIFIST, PREY, PREDATOR):
        mental, _ = _feel(tank, 30.0, kind=kind, menaces=menaces, libido_rate=0.025, eaten=1.0)
        assert mental[FEAR] == pytest.approx(min(menaces, 1.0) if kind == PREY else 0.0)
        assert (mental[LIBIDO] > 0) == (kind == PACIFIST)


def test_libido_is_full_about_dusk_and_low_at_other_hours_except_where_it_was_set(tank):
    full = {"kind": PACIFIST, "libido_rate": 0.025, "eaten": 4.0, "appetite": 4.0, "digestion": 0.0}
    found = [
        float(_feel(tank, 60.0, hour=hour, **full)[0][LIBIDO])
        for hour in (0.0, 6.0, 12.0, 16.0, 16.25, 16.5, 18.0, 19.0, 19.5, 20.0)
    ]
    assert found == pytest.approx([0.1, 0.1, 0.1, 0.1, 0.55, 1.0, 1.0, 1.0, 0.55, 0.1])
    everywhen, _ = _feel(tank, 60.0, hour=12.0, day_libido=1.0, **full)
    betrothed, _ = _feel(tank, 60.0, hour=12.0, betrothed=0, **full)
    ardent, _ = _feel(tank, 60.0, hour=12.0, ardent=True, **full)
    assert everywhen[LIBIDO] == betrothed[LIBIDO] == ardent[LIBIDO] == 1.0
