"""The last fault of a dive that went on, for its presenter and for monitors."""

import time
from collections.abc import Callable

import msgspec

from subsea.base.console import say
from subsea.base.errors import printable


class FaultState(msgspec.Struct, frozen=True):
    """A fault, and how long ago it was."""

    text: str
    ago_s: float


class FaultLog:
    """Remembers the last fault."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """`clock` gives the time, s."""
        self._clock, self._text, self._at_s = clock, "", 0.0

    def add(self, text: str) -> None:
        """Remember a fault that has just happened."""
        self._text, self._at_s = printable(text), self._clock()

    def say(self, text: str) -> None:
        """Report a fault on the terminal, and remember it."""
        say(text)
        self.add(text)

    @property
    def state(self) -> FaultState | None:
        """The last fault; None if there was none."""
        return FaultState(self._text, round(self._clock() - self._at_s, 1)) if self._text else None
