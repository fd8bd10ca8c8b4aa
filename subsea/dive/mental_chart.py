"""The last minute of a fish's hunger, libido and fear, for plots (Tu fig. 9.4)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.state import MENTAL_STATES
from subsea.world.world import TICK_S, World

SPAN = round(60.0 / TICK_S)  # ticks
GAP = 40  # ticks: a longer gap clears the chart


class Chart:
    """A value of each mental state of one fish for every tick of the last minute.

    A ring buffer, stored twice so that the last minute is always contiguous.
    """

    def __init__(self, fish: int) -> None:
        """Start empty."""
        self.fish = fish
        self._values = np.zeros((len(MENTAL_STATES), 2 * SPAN), np.float32)
        self._tick, self._ticks = 0, 0  # the last known tick, and the number of known ticks

    def follow(self, world: World) -> None:
        """Add the current values, also for the ticks since the last call.

        Values after a rewind are dropped, and all after a long gap.
        """
        tick, mental = world.state.tick, world.state.minds.mental[self.fish]
        new = tick - self._tick
        if not self._ticks or not -self._ticks < new <= GAP:
            self._ticks, new = 0, 1
        for at in range(tick - max(new, 1) + 1, tick + 1):
            self._values[:, at % SPAN] = self._values[:, at % SPAN + SPAN] = mental
        self._tick, self._ticks = tick, min(self._ticks + new, SPAN)

    @property
    def values(self) -> NDArray[np.floating[Any]]:
        """(3, k) float32, rows as `MENTAL_STATES`, the last column is now: no copy."""
        end = self._tick % SPAN + SPAN + 1
        return self._values[:, end - self._ticks : end]
