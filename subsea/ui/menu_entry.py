"""A line of the menu."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

ROW = 1.75  # height of an entry, in heights of letters
ABOUT = 0.65  # height of the line below an entry


class Entry(NamedTuple):
    """A line of the menu, in the language of visitors."""

    text: str
    act: Callable[[], object]
    aside: str = ""  # text at its right end
    chosen: bool = False
    about: str = ""  # a line below it
    scenario: Path | None = None  # the file whose picture is at its left end

    @property
    def high(self) -> float:
        """Its height, in heights of letters."""
        return ROW + ABOUT if self.about else ROW
