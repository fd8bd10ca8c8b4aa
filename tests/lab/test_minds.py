"""Hunger, intentions, meals and escapes over tiny records."""

import numpy as np
import pytest

from subsea.lab.measures import changes_per_second, escapes, meals, saturated, time_budget
from subsea.state import AVOID, EAT, ESCAPE, FEAR, HUNGER, PREDATOR, SCHOOL, WANDER
from tests.support.records import a_record, still


def test_hunger_is_saturated_after_a_minute_if_there_is_food():
    ticks = 2000
    mental = np.zeros((ticks, 3, 3), np.float32)
    mental[100:750, 0, HUNGER] = 1.0  # 65 s
    mental[100:650, 1, HUNGER] = 1.0  # 55 s
    mental[:, 2, HUNGER] = 1.0
    record = a_record(still(ticks, *[(0, 0, -9)] * 3), mental_state=mental,
                      kind=np.array([0, 0, PREDATOR]))  # fmt: skip
    found = saturated(record)
    assert found.sum(axis=0).tolist() == [650, 0, 0]
    barren = record._replace(plankton=np.zeros(ticks, np.int32))
    assert not saturated(barren).any()


def test_time_budget_counts_the_living():
    intention = np.array([[EAT, WANDER], [EAT, WANDER], [SCHOOL, WANDER], [SCHOOL, AVOID]])
    alive = np.array([[1, 1], [1, 1], [1, 1], [1, 0]], bool)
    record = a_record(still(4, (0, 0, -9), (0, 0, -9)), intention=intention, alive=alive,
                      species=np.array([0, 1]), species_names=["A", "B"])  # fmt: skip
    budget = time_budget(record)
    assert budget[0, EAT] == budget[0, SCHOOL] == 0.5
    assert budget[1, WANDER] == 1.0
    assert budget.sum(axis=1) == pytest.approx(1.0)


def test_changes_of_intention_per_second():
    intention = np.full((101, 2), WANDER)
    intention[::2, 0] = EAT
    intention[50:, 1] = SCHOOL
    record = a_record(still(101, (0, 0, -9), (0, 0, -9)), intention=intention)
    assert changes_per_second(record) == pytest.approx([10.0, 0.1])


def test_meals_are_new_times_of_the_last_one():
    eaten = np.array([[0, 3], [0, 3], [0.2, 3], [0.2, 3], [0.4, 3]], np.float32)
    record = a_record(still(5, (0, 0, -9), (0, 0, -9)), last_meal=eaten)
    assert meals(record).sum(axis=0).tolist() == [2, 0]


def test_escapes_after_fear():
    intention = np.full((60, 2), WANDER)
    intention[20:30, 0] = intention[40:50, 0] = intention[40:50, 1] = ESCAPE
    mental = np.zeros((60, 2, 3), np.float32)
    mental[15:17, 0, FEAR] = 0.8  # 0.5 s before the first; nothing before the others
    mental[25:29, :, FEAR] = 0.8  # 1.1 s before
    record = a_record(still(60, (0, 0, -9), (0, 0, -9)), intention=intention, mental_state=mental)
    assert escapes(record) == (3, 1)
