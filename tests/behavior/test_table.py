"""Desires and routines are called by the table of behaviors."""

import numpy as np

from subsea.behavior import table
from subsea.kernels import kernel


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
