"""Rows of numbers that kernels read as the rules of a school."""

import math
from typing import Any

from subsea.scenario.school_rules import MAX_GOALS, NAMES, USUAL, Goal, SchoolRules

# Columns of `Minds.rules`.
(
    SEPARATION_BL, ATTRACTION_BL, FULL_ATTRACTION_BL,
    INERTIA, ALIGNMENT, SEPARATION, ATTRACTION, GOAL, REJOIN,
    NOISE_RAD, NOISE_S, PACE_NOISE, ATTENDED, BLIND_COS, SIGHT_BL, LATERAL_LINE_BL,
    INFORMED, GOAL_FEEDBACK, REST, MOODS, CONTAGION, GOALS,
) = range(22)  # fmt: skip
# Columns of a goal, from GOALS on: share, kind, then a place, cm, or a unit vector.
GOAL_SHARE, GOAL_KIND, GOAL_X, GOAL_Y, GOAL_Z = range(5)
GOAL_COLUMNS = 5
NO_GOAL, PLACE, HEADING = 0.0, 1.0, 2.0
RULE_COLUMNS = GOALS + MAX_GOALS * GOAL_COLUMNS


def rule_row(rules: SchoolRules) -> tuple[float, ...]:
    """Convert rules that have all keys to a row of `Minds.rules`."""
    goals = [number for goal in rules.goals or () for number in _goal_row(goal)]
    given: dict[str, Any] = {name: getattr(rules, name) for name in NAMES}
    given["noise_deg"] = math.radians(given["noise_deg"])
    given["blind_deg"] = -math.cos(math.radians(0.5 * given["blind_deg"]))
    row = [float(given[name]) for name in NAMES if name != "goals"] + goals
    return (*row, *[0.0] * (RULE_COLUMNS - len(row)))


def _goal_row(goal: Goal) -> tuple[float, ...]:
    if goal.position_cm is not None:
        return (goal.share, PLACE, *goal.position_cm)
    angle = math.radians(goal.heading_deg or 0.0)
    return goal.share, HEADING, math.cos(angle), math.sin(angle), 0.0


USUAL_RULES = rule_row(USUAL)
