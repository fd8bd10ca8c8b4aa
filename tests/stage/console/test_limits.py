"""A rate limit lets bursts through, and refuses what is over the rate."""

from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.console.http import RateLimit


@given(st.lists(st.floats(0.0, 0.2), max_size=200))
def test_no_more_than_the_rate_is_let_through(gaps):
    now = [0.0]
    limit = RateLimit(10.0, 5, lambda: now[0])
    assert [limit.allow() for _ in range(6)] == [True] * 5 + [False]
    now[0] = 60.0
    passed = []
    for gap in gaps:
        now[0] += gap
        if limit.allow():
            passed.append(now[0])
    assert len(passed) >= min(len(gaps), 5)
    for k, begin in enumerate(passed):
        within = sum(begin <= moment < begin + 1.0 for moment in passed[k:])
        assert within <= 5 + 10 + 1
