"""Play a show: which item is on, how dark the screens are, and cues. Nothing here has windows."""

from collections.abc import Callable

import msgspec

from subsea.dive.captions import FADE_S, Caption, shown_s
from subsea.stage.opening_hours import clock_text, is_open, spans_on
from subsea.stage.show import (
    JUMP_S,
    Progress,
    ShowClock,
    advance,
    begin,
    clock_now,
    jump_s,
    resume,
    waits_for,
)
from subsea.stage.show_file import Show, ShowItem

STEP_S = 0.25  # longest step of a fade: a sea was loaded since the last picture


class ShowStatus(msgspec.Struct, frozen=True, kw_only=True):
    """A show at a moment, for a presenter."""

    title: str
    item: int  # from 1
    items: int
    scenario: str | None  # None: that of the item before
    tour: str | None
    elapsed_s: float
    next: str  # what starts the next item: "cue", a time, seconds; empty: nothing
    open: bool
    shade: float  # 1: the screens are black


class ShowPlayer:
    """The state of a running show. A console calls `next_cue` and `state`."""

    def __init__(
        self,
        show: Show,
        tell: Callable[[str], object],
        saved: Progress | None = None,
        clock: Callable[[], ShowClock] = clock_now,
    ) -> None:
        """Begin, or resume what was `saved`; `tell` gets a line on each jump of the clock."""
        self.show, self._tell, self._clock = show, tell, clock
        now = clock()
        self.progress = begin(show, now) if saved is None else resume(show, saved, now)
        self.open = is_open(show.hours, now.local)
        self.shown: int | None = None  # the item whose sea is on the screens
        self.shade = 1.0  # of the screens
        self._cue, self._loaded = False, False
        self._caption_s = 0.0  # since the shown item became visible

    def next_cue(self) -> None:
        """Go on to the next item now, whatever it waits for."""
        self._cue = True

    def state(self) -> ShowStatus:
        """The state, for a presenter."""
        one = self.item
        return ShowStatus(
            title=self.show.title,
            item=self.progress.item + 1,
            items=len(self.show.item),
            scenario=one.scenario,
            tour=one.tour,
            elapsed_s=self.progress.elapsed_s,
            next=waits_for(self.show, self.progress),
            open=self.open,
            shade=self.shade,
        )

    @property
    def item(self) -> ShowItem:
        """The item that is on."""
        return self.show.item[self.progress.item]

    @property
    def closed(self) -> bool:
        """True while the screens are blank outside the opening hours."""
        return not self.open and self.shade >= 1.0

    @property
    def due(self) -> int | None:
        """The item to be shown, once the screens are dark; None: the right one is."""
        wanted = self.open and self.shade >= 1.0 and self.shown != self.progress.item
        return self.progress.item if wanted else None

    def update(self, elapsed_s: float) -> None:
        """Go on, `elapsed_s` after the last call."""
        now, before = self._clock(), self.progress
        cue, self._cue = self._cue, False
        if not self._loaded:  # loading took time that is not of the show: the clock is right
            before = msgspec.structs.replace(before, utc_s=now.utc_s - elapsed_s)
            self._loaded = True
        if abs(jump := jump_s(before, now, elapsed_s)) > JUMP_S:
            way = "forward" if jump > 0.0 else "back"
            self._tell(f"the clock went {way} by {abs(jump):.0f} s; the show goes on")
        was_open, self.open = self.open, is_open(self.show.hours, now.local)
        if self.open and not was_open:
            self.progress, self.shown = begin(self.show, now), None
            self._tell("the show opens")
        elif self.open:
            self.progress = advance(self.show, before, now, elapsed_s, cue)
        else:
            self.progress = msgspec.structs.replace(before, seen=now.local, utc_s=now.utc_s)
            if was_open:
                self._tell(f"the show closes; {self._next_opening(now)}")
        self._fade(elapsed_s)

    def show_item(self, item: int) -> None:
        """Note that an item's sea is ready to be seen."""
        if item != self.shown:
            self._caption_s = 0.0
        self.shown = item

    def caption(self) -> Caption:
        """The caption of the shown item, which comes with its first picture."""
        if self.shown is None or not self.show.item[self.shown].caption:
            return Caption()
        one = self.show.item[self.shown]
        left_s = shown_s(one.caption, one.caption_s) - self._caption_s
        share = min(max(min(self._caption_s, left_s) / FADE_S, 0.0), 1.0)
        return Caption(one.caption, share * share * (3.0 - 2.0 * share))

    def _fade(self, elapsed_s: float) -> None:
        """Darken before another item and outside the hours, else lighten."""
        dark = not self.open or self.shown != self.progress.item
        given = self.item.fade_s
        fade_s = self.show.fade_s if given is None else given
        elapsed_s = min(elapsed_s, STEP_S)
        step = 1.0 if fade_s == 0.0 else elapsed_s / fade_s
        self.shade = min(max(self.shade + (step if dark else -step), 0.0), 1.0)
        if not dark:
            self._caption_s += elapsed_s

    def _next_opening(self, now: ShowClock) -> str:
        hours = self.show.hours
        later = [] if hours is None else spans_on(hours, now.local.date())
        minute = 60 * now.local.hour + now.local.minute
        for first, _ in later:
            if first > minute:
                return f"it opens at {clock_text(first)}"
        return "it opens on another day"
