"""The clock neither gains, loses nor skips time, and cannot spiral into overload."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.dive.idle_timer import MAX_TICKS_PER_FRAME, TickClock

TICK = 0.033
FRAMES = st.lists(st.floats(0.0, 0.15), max_size=200)


@given(FRAMES)
def test_no_time_is_lost_on_a_machine_that_keeps_up(frames):
    clock = TickClock(TICK)
    ticks = sum(clock.advance(elapsed) for elapsed in frames)
    assert (ticks + clock.alpha) * TICK == pytest.approx(sum(frames), abs=1e-9)


@given(st.lists(st.floats(-1.0, 100.0), max_size=100))
def test_a_long_frame_never_skips_or_spirals(frames):
    clock = TickClock(TICK)
    for elapsed in frames:
        assert 0 <= clock.advance(elapsed) <= MAX_TICKS_PER_FRAME
        assert 0.0 <= clock.alpha <= 1.0
    clock.advance(1000.0)
    assert clock.advance(0.0) == 0  # time beyond the limit is dropped


@given(st.integers(20, 240))
def test_drawing_advances_evenly_at_any_display_rate(rate):
    clock = TickClock(TICK)
    drawn, ticks = [], 0
    for _ in range(200):
        ticks += clock.advance(1.0 / rate)
        drawn.append(ticks + clock.alpha)
    steps = [b - a for a, b in pairwise(drawn)]
    assert max(steps) - min(steps) < 1e-6
