"""Convert real time to ticks."""

MAX_TICKS_PER_FRAME = 5  # below 6 frames a second the world slows down


class TickClock:
    """Converts uneven frame times to ticks of equal length.

    The remainder, shorter than a tick, is carried over; `alpha` is its share of a tick, at which
    to draw between the last two ticks. A long frame makes at most MAX_TICKS_PER_FRAME: a slow
    computer shows slow motion, never a jump.
    """

    def __init__(self, tick_s: float, max_ticks: int = MAX_TICKS_PER_FRAME) -> None:
        """No time is left over."""
        self.tick_s = tick_s
        self.max_ticks = max_ticks
        self._owed_s = 0.0

    def advance(self, elapsed_s: float) -> int:
        """The number of ticks to make, `elapsed_s` after the last call."""
        self._owed_s += max(elapsed_s, 0.0)
        ticks = int(self._owed_s / self.tick_s)
        self._owed_s = max(self._owed_s - ticks * self.tick_s, 0.0)
        return min(ticks, self.max_ticks)

    def fill(self) -> None:
        """Set the remainder to a whole tick, so that `alpha` is 1."""
        self._owed_s = self.tick_s

    @property
    def alpha(self) -> float:
        """Share of the next tick that has passed, in [0, 1]: weight of the newer of two states."""
        return min(self._owed_s / self.tick_s, 1.0)
