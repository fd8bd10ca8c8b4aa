"""Parts that wings and other packages add to a dive, such as a console or a headset.

The group `subsea.dive_parts` of entry points names subclasses of `DivePart`. They load what they
need when they are planned, not at import, as the window is to appear at once.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from subsea.base.errors import UserError
from subsea.base.registry import DIVE_PARTS, load_all

if TYPE_CHECKING:
    from subsea.dive.options import DiveOptions
    from subsea.dive.presented import Presented
    from subsea.dive.tick_source import TickSourceMaker
    from subsea.world.world import World

GOES_ON = "the dive goes on in the window"


class LostDisplayError(UserError):
    """A display beside the window ended; the message says so in one line."""


class DivePart:
    """A part of a dive; a method that a part does not need does nothing.

    `dive` is the `subsea.ui.dive.Dive`.
    """

    leads = False  # True if nodes of a cluster follow the scenarios that it opens
    waits = False  # True if no window may open before it is planned

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add options to `subsea dive`."""

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "DivePart | None":
        """Check the options and make the part; None if nobody asked for it."""

    def check(self, options: "DiveOptions") -> None:
        """Raise a UserError if a dive with these options would end at its start."""

    def instead(self, options: "DiveOptions", words: Sequence[str]) -> int | None:
        """Do something instead of the dive that `words` ask for; returns the exit code."""

    def plan(self, options: "DiveOptions") -> "DiveOptions":
        """Load what the part needs; returns the options that the dive goes by from now on."""
        return options

    def installation(self, options: "DiveOptions") -> "tuple[Any, TickSourceMaker] | None":
        """Return the windows (`ui.monitors.Installation`) and source of ticks that replace ours."""

    def opened(self, dive: Any) -> None:
        """Act when the windows are open."""

    def worn(self, dive: Any) -> Any:
        """Return a display on the head, as `stage.headset.display.HeadsetDisplay`; or None."""

    def restore(self, world: "World") -> None:
        """Change a world before its first tick in the dive."""

    def begin(self, dive: Any) -> None:
        """Begin: the sea is shown, and the first picture follows."""

    def beat(self) -> None:
        """Note that the dive is alive, while it loads."""

    def before(self, dive: Any, elapsed_s: float) -> bool:
        """Act before the ticks of a picture, `elapsed_s` after the last; True: it stays black."""
        return False

    def over(self, presented: "Presented") -> "Presented":
        """Add to what lies over the sea."""
        return presented

    def cue(self) -> None:
        """Act on the key for the next cue."""

    def ticked(self, dive: Any) -> None:
        """Act after the ticks of a picture, before it is drawn."""

    def after(self, dive: Any) -> None:
        """Look at a picture that is drawn, before it is shown."""

    def shown(self, dive: Any) -> None:
        """Act after a picture was shown."""

    def may_end(self) -> bool:
        """True at a moment when the dive may end without cutting off what the audience sees."""
        return True

    def end(self, dive: Any) -> None:
        """End in order: the window was closed, or the time of the dive is over."""

    def close(self) -> None:
        """Release everything, after an error too; a second call does nothing."""


def part_kinds() -> list[type[DivePart]]:
    """Return all registered parts."""
    return [kind for _, kind in load_all(DIVE_PARTS)]


def with_parts(options: Namespace, dive: "DiveOptions") -> "DiveOptions":
    """Return the options of a dive with the parts that options of `subsea dive` ask for."""
    made = (kind.made(options, dive) for kind in part_kinds())
    return replace(dive, parts=tuple(part for part in made if part is not None))


def planned(options: "DiveOptions") -> "DiveOptions":
    """Plan all parts of a dive; returns the options that it goes by."""
    for part in options.parts:
        options = part.plan(options)
    return options
