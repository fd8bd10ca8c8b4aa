"""Bursts and the time that they last."""

import numpy as np
import pytest

from subsea.behavior.chasing import FRESH, LASTING_S, RECOVERS, burst, tire
from tests.support.scenes import everyone


def test_a_burst_fades_and_recovers_with_rest(tank):
    t = tank(2)
    t.fishes.burst[:] = 4.0
    speeds = []
    for _ in range(200):
        burst(t.fishes, t.minds, 0)
        speeds.append(float(t.fishes.goal_speed[0]))
        tire(everyone(t.fishes), t.fishes, t.minds, t.clock)
    # Full speed for a while; then the share of burst falls by itself, exponentially.
    seconds = t.clock.dt * np.arange(200) - FRESH * LASTING_S
    share = np.exp(-np.maximum(seconds, 0.0) / ((1.0 - FRESH) * LASTING_S))
    assert speeds == pytest.approx(1.0 + 3.0 * share, abs=0.04)
    spent = float(t.minds.spent[0])
    t.fishes.goal_speed[:] = 0.5
    tire(everyone(t.fishes), t.fishes, t.minds, t.clock)
    assert t.minds.spent[0] == pytest.approx(spent - RECOVERS * t.clock.dt)
    assert t.minds.spent[1] == 0.0


def test_a_species_without_a_burst_swims_at_its_fastest(tank):
    t = tank()
    burst(t.fishes, t.minds, 0)
    assert t.fishes.goal_speed[0] == 1.0
    tire(everyone(t.fishes), t.fishes, t.minds, t.clock)
    assert t.minds.spent[0] == 0.0
