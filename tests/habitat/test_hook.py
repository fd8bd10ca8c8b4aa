"""The way of the hook."""

import numpy as np
import pytest

from subsea.habitat.sea import OUT_CM, hook_constants, move_hook
from subsea.habitat.sea import make_sea as make_scenario_sea
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Hook
from subsea.state import HANGING, HOOKED, LANDED, NOBODY, SINKING, STOWED, Clock

PLAN = Hook(position_cm=(40.0, -10.0), depth_cm=300.0, speed_cm_s=30.0, start_s=2.0)
DT = 0.033


@pytest.fixture
def sea(make_sea):
    return make_sea()._replace(tackle=hook_constants(PLAN))


def _until(sea, state, tick=0):
    while sea.catch[0] != state:
        assert tick < 2000
        move_hook(sea, Clock(1, tick, DT))
        tick += 1
    return tick


def test_it_comes_in_time_sinks_at_its_speed_and_hangs(sea):
    assert sea.catch.tolist() == [STOWED, NOBODY]
    begun = _until(sea, SINKING)
    assert begun * DT == pytest.approx(2.0, abs=2 * DT)
    assert sea.hook.tolist() == [40, -10, 0]
    down = _until(sea, HANGING, begun)
    assert (down - begun) * DT == pytest.approx(300 / 30, abs=2 * DT)
    assert sea.hook.tolist() == [40, -10, -300]
    for tick in range(down, down + 100):
        move_hook(sea, Clock(1, tick, DT))
    assert sea.catch[0] == HANGING


def test_it_is_drawn_up_with_its_catch_and_stays_away(sea):
    tick = _until(sea, HANGING)
    sea.catch[:] = HOOKED, 7
    up = _until(sea, LANDED, tick)
    assert (up - tick) * DT == pytest.approx((300 + OUT_CM) / 30, abs=2 * DT)
    for more in range(up, up + 200):
        move_hook(sea, Clock(1, more, DT))
    assert sea.catch[0] == LANDED


def test_without_a_hook_none_ever_comes():
    sea = make_scenario_sea(load_scenario("peaceful")[0], np.random.default_rng(1))[0]
    move_hook(sea, Clock(1, 10**9, DT))
    assert sea.catch[0] == STOWED
