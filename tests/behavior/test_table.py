"""Desires and routines are called by the table of behaviors."""

import numpy as np

from subsea.behavior import table
from subsea.kernels import kernel
from subsea.state import GUARD, NOBODY, YIELD


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


def test_desires_come_by_urgency_and_each_intention_runs_its_routine(tank, monkeypatch):
    behaviors = (
        table.Behavior("stop", stop, ((table.EASE, weak),)),
        table.Behavior("rush", rush, ((table.DANGER, strong), (table.EASE, weak))),
    )
    desires = table.desires_of(behaviors)
    assert [row[:2] for row in desires] == [(table.DANGER, 1), (table.EASE, 0), (table.EASE, 1)]
    monkeypatch.setattr(table, "BEHAVIORS", behaviors)
    monkeypatch.setattr(table, "DESIRES", desires)
    t = tank(2)
    given = np.arange(2), t.fishes, t.minds, t.sea, t.nature, t.clock
    table.compute_desires(*given)
    assert t.minds.desire[:3].tolist() == [[0.75, 0.75], [0.25, 0.25], [0.25, 0.25]]
    t.minds.intention[:] = 1, 0
    table.run_routines(*given)
    assert t.fishes.goal_speed.tolist() == [1.0, 0.0]


def test_a_fish_that_lost_what_it_seeks_wanders(tank):
    t = tank(3)
    minds = t.minds
    minds.intention[:] = GUARD, GUARD, YIELD
    minds.intruder[:], minds.chaser[:] = (1, NOBODY, NOBODY), NOBODY
    minds.home[:], minds.home_range[:] = t.fishes.position, np.inf
    t.fishes.position[1] = 60.0, 0.0, -300.0
    t.fishes.fast[:] = 60.0
    minds.desire[np.flatnonzero(table.BEHAVIOR_OF_DESIRE == GUARD), 0] = 0.9
    minds.waypoint[:] = t.fishes.position + np.float32([0.0, 400.0, 0.0])
    minds.patience[:] = 100.0
    table.run_routines(np.arange(3), t.fishes, minds, t.sea, t.nature, t.clock)
    ahead = minds.urge[:, 0] > 0.9 * np.linalg.norm(minds.urge, axis=1)
    assert ahead.tolist() == [True, False, False]  # to its intruder; the others to their left
    assert minds.intention.tolist() == [GUARD, GUARD, YIELD]
