"""Limits on the rate of requests."""

import time
from collections.abc import Callable

PATIENCE_S = 2.0  # longest delay of a request before it is refused


class RateLimit:
    """Delays requests that come faster than a rate, and refuses those of a flood."""

    def __init__(
        self, per_s: float, burst: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """`burst` requests may come at once, then `per_s` in a second. `clock` gives s."""
        self._per_s, self._burst, self._clock = per_s, burst, clock
        self._left, self._last_s = float(burst), clock()

    def delay(self) -> float | None:
        """Seconds that one more request must wait; None: refuse it."""
        now = self._clock()
        self._left = min(self._left + (now - self._last_s) * self._per_s, float(self._burst))
        self._last_s = now
        if self._left < 1.0 - PATIENCE_S * self._per_s:
            return None
        self._left -= 1.0
        return max(-self._left / self._per_s, 0.0)
