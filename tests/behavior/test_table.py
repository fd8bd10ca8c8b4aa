"""Compiled entries call the listed behaviors in the order of the table."""

import inspect
import re

from subsea.behavior import table


def test_desires_are_computed_in_the_order_of_the_table():
    body = inspect.getsource(table.compute_desires.py_func)
    calls = re.findall(r"(\w+)\.(\w+)\(who,.*out\[(\d+)\]\)\n", body)
    found = [(getattr(getattr(table, module), name), int(row)) for module, name, row in calls]
    assert found == [(desire, row) for row, (_, _, desire) in enumerate(table.DESIRES)]


def test_each_intention_runs_its_own_routine():
    body = inspect.getsource(table.run_routine.py_func)
    calls = re.findall(r"code == (\d+):\n +(\w+)\.(\w+)\(who, ", body)
    found = [(getattr(getattr(table, module), name), int(code)) for code, module, name in calls]
    assert found == [(behavior.routine, code) for code, behavior in enumerate(table.BEHAVIORS)]
