"""Goals of schools: the fishes that know them, the way there, and feedback."""

import numpy as np
import pytest

from subsea.behavior.school_goals import goal_of, lot
from subsea.scenario.school_rules import Goal, SchoolRules, merged
from subsea.state.school_rules import rule_row


def _with(tank, n, *goals, **rules):
    t = tank(n)
    t.minds.leader[1:], t.minds.leads[0] = 0, True
    t.minds.rules[0] = rule_row(merged([SchoolRules(goals=list(goals), **rules)]))
    return t


def _goals(t):
    return np.array([goal_of(t.fishes, t.minds, i, 0, t.clock) for i in range(len(t.minds.leader))])


@pytest.mark.parametrize("n", [20, 50, 400])
def test_two_shares_have_two_goals(tank, n):
    """As many as the shares say, up to two."""
    goals = Goal(share=0.1, heading_deg=90.0), Goal(share=0.3, heading_deg=-90.0)
    sides = _goals(_with(tank, n, *goals))[:, 1]
    assert abs((sides > 0.9).sum() - 0.1 * n) <= 2
    assert abs((sides < -0.9).sum() - 0.3 * n) <= 2
    assert (sides == 0).sum() == n - (np.abs(sides) > 0.9).sum()


def test_a_place_is_headed_for_and_fades_nearby(tank):
    t = _with(tank, 2, Goal(share=1.0, position_cm=(600.0, 0.0, -300.0)))
    t.fishes.position[1] = 540.0, 0.0, -300.0
    np.testing.assert_allclose(_goals(t), [[1, 0, 0], [0.5, 0, 0]], atol=1e-6)


def test_feedback_weakens_a_goal_off_course(tank):
    """The fish heads along x."""
    sizes = []
    for angle in (0.0, 60.0, 180.0):
        goal = Goal(share=1.0, heading_deg=angle)
        sizes.append(np.linalg.norm(_goals(_with(tank, 1, goal, goal_feedback=2.0))[0]))
    np.testing.assert_allclose(sizes, [1.0, 0.25, 0.01], atol=1e-4)


def test_lots_differ_between_schools_and_seeds():
    drawn = {round(lot(school + 3, school, seed), 6) for school in range(5) for seed in range(5)}
    assert len(drawn) == 25
    assert all(0.0 <= one < 1.0 for one in drawn)
