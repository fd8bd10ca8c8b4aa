"""A rate limit lets bursts through, delays what is over the rate, and refuses floods."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.console.board import PATIENCE_S, RateLimit


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_a_burst_passes_and_the_rest_waits_in_turn():
    clock = Clock()
    limit = RateLimit(10.0, 5, clock)
    assert [limit.delay() for _ in range(5)] == [0.0] * 5
    assert [limit.delay() for _ in range(3)] == pytest.approx([0.1, 0.2, 0.3])
    clock.now = 60.0
    assert [limit.delay() for _ in range(5)] == [0.0] * 5


@given(st.lists(st.floats(0.0, 0.2), max_size=200))
def test_no_more_than_the_rate_is_let_through(gaps):
    clock = Clock()
    limit = RateLimit(10.0, 5, clock)
    passed = []
    for gap in gaps:
        clock.now += gap
        if (wait := limit.delay()) is not None:
            assert wait <= PATIENCE_S
            passed.append(clock.now + wait)
    for k, begin in enumerate(passed):
        within = sum(begin <= one < begin + 1.0 for one in passed[k:])
        assert within <= 5 + 10 + 1
