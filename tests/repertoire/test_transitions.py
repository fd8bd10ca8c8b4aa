"""Rows at which playback may leave and enter a segment."""

import dataclasses

import numpy as np

from subsea.repertoire.transitions import LEAVING_SHARE, plan_transitions


def test_acyclic_segments_are_left_late_and_an_escape_is_entered_from_anywhere(known_repertoire):
    """An escape is planned from the middle of a sharp turn too."""
    swim, turn = (known_repertoire.segments[name] for name in ("swim_fast", "turn_left_sharp"))
    escape = dataclasses.replace(turn, grade="wide")
    plan = plan_transitions([swim, turn, escape])
    rows = len(swim.nodes)
    late = rows + round((1.0 - LEAVING_SHARE) * rows)
    assert not plan.leave[rows:late].any()
    assert plan.leave[late : 2 * rows].any(axis=0).all()
    assert plan.leave[:rows].any(axis=0).all()
    assert (plan.entry[:, 2] == 2 * rows).all()
    assert (plan.frames[rows:late, 2] > 1).any()
    assert np.isin(plan.entry[:, 0], range(rows)).all()
