"""Compiled entries call the listed behaviors in the order of the table."""

import inspect
import re

from subsea.behavior import table


def _calls(entry):
    """Functions that an entry calls, each with the row or code of its line."""
    body = inspect.getsource(entry.py_func)
    line = r"(\w+)\.(\w+)\(who(?:\[now == (\d+)\])?,.*?(?:out\[(\d+)\])?\)\n"
    calls = re.findall(line, body)
    return [(getattr(getattr(table, module), name), int(a or b)) for module, name, a, b in calls]


def test_desires_are_computed_in_the_order_of_the_table():
    rows = [(desire, row) for row, (_, _, desire) in enumerate(table.DESIRES)]
    assert _calls(table.compute_desires) == rows


def test_each_intention_runs_its_own_routine():
    rows = [(behavior.routine, code) for code, behavior in enumerate(table.BEHAVIORS)]
    assert _calls(table.run_routines) == rows
