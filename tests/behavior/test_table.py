"""Desires and routines are called by the table of behaviors."""

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.behavior import table
from subsea.kernels import kernel
from subsea.state import GUARD, NOBODY, SCHOOL, YIELD


@kernel
def weak(who, fishes, minds, sea, nature, clock, out):
    out[who] = 0.25


@kernel
def strong(who, fishes, minds, sea, nature, clock, out):
    out[who] = 0.75


@kernel
def stop(who, fishes, minds, sea, nature, clock):
    fishes.goal_speed[who] = 0.0


@kernel
def rush(who, fishes, minds, sea, nature, clock):
    fishes.goal_speed[who] = 1.0


def test_desires_come_by_urgency_and_each_intention_runs_its_routine(tank):
    behaviors = (
        table.Behavior("stop", stop, ((table.EASE, weak),)),
        table.Behavior("rush", rush, ((table.DANGER, strong), (table.EASE, weak))),
    )
    desires = table.desires_of(behaviors)
    assert [row[:2] for row in desires] == [(table.DANGER, 1), (table.EASE, 0), (table.EASE, 1)]
    t = tank(2)
    own = table.make_table(behaviors)
    given = np.arange(2), t.fishes, t.minds, t.sea, t.nature, t.clock
    table.compute_desires(*given, own.shared)
    assert t.minds.desire[:3].tolist() == [[0.75, 0.75], [0.25, 0.25], [0.25, 0.25]]
    t.minds.intention[:] = 1, 0
    table.run_routines(*given, own)
    assert t.fishes.goal_speed.tolist() == [1.0, 0.0]


def test_a_fish_that_lost_what_it_seeks_wanders(tank):
    t = tank(3)
    minds = t.minds
    minds.intention[:] = GUARD, GUARD, YIELD
    minds.intruder[:], minds.chaser[:] = (1, NOBODY, NOBODY), NOBODY
    minds.home[:], minds.home_range[:] = t.fishes.position, np.inf
    t.fishes.position[1] = 60.0, 0.0, -300.0
    t.fishes.fast[:] = 60.0
    minds.desire[np.flatnonzero(table.TABLE.behavior == GUARD), 0] = 0.9
    minds.waypoint[:] = t.fishes.position + np.float32([0.0, 400.0, 0.0])
    minds.patience[:] = 100.0
    table.run_routines(np.arange(3), t.fishes, minds, t.sea, t.nature, t.clock)
    ahead = minds.urge[:, 0] > 0.9 * np.linalg.norm(minds.urge, axis=1)
    assert ahead.tolist() == [True, False, False]  # to its intruder; the others to their left
    assert minds.intention.tolist() == [GUARD, GUARD, YIELD]


def test_a_behavior_replaces_ours_of_its_name_or_comes_after_them():
    ours = table.BEHAVIORS[SCHOOL]
    doze = table.Behavior("doze", stop, ((table.EASE, weak),))
    made = table.with_behaviors([table.Behavior("school", rush, ()), doze])
    assert made.names == (*table.INTENTIONS, "doze")
    assert made.behaviors[SCHOOL].routine is rush
    assert made.behaviors[SCHOOL].desires == ours.desires
    assert len(made.desires) == len(table.TABLE.desires) + 1
    with pytest.raises(UserError, match=r"behavior 'scool' needs a desire, .*mean 'school'"):
        table.with_behaviors([table.Behavior("scool", rush, ())])
    with pytest.raises(UserError, match="behavior 'doze' is given twice"):
        table.with_behaviors([doze, doze])


def test_what_takes_all_fishes_is_never_cut_up(tank):
    calls = []

    def wish(who, fishes, minds, sea, nature, clock, out):
        calls.append(("wish", len(who)))
        out[who] = 0.5

    def act(who, fishes, minds, sea, nature, clock):
        calls.append(("act", len(who)))

    n = 2 * table.LEAST_PART + 2
    t = tank(n)
    own = table.make_table([table.Behavior("all", act, ((table.EASE, wish),), whole=True)])
    given = np.arange(n), t.fishes, t.minds, t.sea, t.nature, t.clock
    t.minds.intention[:] = 0
    table.compute_desires(*given, own.shared)
    assert not calls
    table.compute_desires(*given, own.whole)
    table.run_routines(*given, own)
    assert calls == [("wish", n), ("act", n)]
