"""Convert real time to ticks; start and end tours by the time since the last input."""

from typing import Literal

DIP_S = 1.0  # the picture fades to dark before a tour that begins elsewhere, and back after


class IdleTimer:
    """Decides when a tour begins: after some time without input; and ends: at any input."""

    def __init__(self, after_s: float, leaps: bool) -> None:
        """`after_s` without input, 0: never. A tour that `leaps` begins elsewhere, in the dark."""
        self.after_s, self.leaps = after_s, leaps
        self.touring = False
        self.shade = 0.0  # darkness of the picture
        self.idle_s = 0.0
        self.toured_s = 0.0

    def begin(self) -> None:
        """Start a tour now."""
        self.touring, self.toured_s = True, 0.0

    def end(self) -> None:
        """End the tour, and wait for the whole time again."""
        self.touring, self.idle_s = False, 0.0

    def update(
        self, active: bool, dt: float, allowed: bool = True
    ) -> Literal["begin", "end"] | None:
        """The action `dt` seconds later. `active`: there was input; `allowed`: a tour may begin."""
        self.idle_s = 0.0 if active else self.idle_s + dt
        self.toured_s += dt
        if active and self.touring:
            self.touring = False
            return "end"
        due = allowed and not self.touring and 0.0 < self.after_s <= self.idle_s
        dark = due and self.leaps
        self.shade = min(max(self.shade + (dt if dark else -dt) / DIP_S, 0.0), 1.0)
        if due and (not self.leaps or self.shade == 1.0):
            self.begin()
            return "begin"
        return None


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
