"""Real time in, ticks of the world out."""

MAX_TICKS_PER_FRAME = 5  # below 6 frames a second the world slows down rather than skips


class TickClock:
    """Turns the uneven time of a display into even ticks.

    The remainder that is too short for a tick is carried over and is `alpha`, the point
    between the last two ticks at which to draw. Time that a long frame owes beyond
    MAX_TICKS_PER_FRAME is forgotten, so that a slow machine shows slow motion, never a jump.
    """

    def __init__(self, tick_s: float, max_ticks: int = MAX_TICKS_PER_FRAME) -> None:
        """Start with no time owed."""
        self.tick_s = tick_s
        self.max_ticks = max_ticks
        self._owed_s = 0.0

    def advance(self, elapsed_s: float) -> int:
        """How many ticks to step now that `elapsed_s` seconds have passed since the last call."""
        self._owed_s += max(elapsed_s, 0.0)
        ticks = int(self._owed_s / self.tick_s)
        self._owed_s = max(self._owed_s - ticks * self.tick_s, 0.0)
        return min(ticks, self.max_ticks)

    def fill(self) -> None:
        """Owe one whole tick, so that `alpha` is 1."""
        self._owed_s = self.tick_s

    @property
    def alpha(self) -> float:
        """Share of the next tick that has passed, in [0, 1]: weight of the newer of two states."""
        return min(self._owed_s / self.tick_s, 1.0)
