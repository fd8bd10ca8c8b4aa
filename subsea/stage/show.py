"""The moment of a show: pure functions of the clock and the state before.

Items last by the time that passes, so that a clock that jumps shortens none. The clock starts
items of a fixed time, each once a day.
"""

from collections.abc import Iterator
from datetime import datetime, timedelta
from typing import NamedTuple

import msgspec

from subsea.stage.opening_hours import clock_text
from subsea.stage.show_file import AFTER, CUE, Show

JUMP_S = 5.0  # difference between clock and passed time that counts as a jump
DAY = timedelta(days=1)


class ShowClock(NamedTuple):
    """A moment: local time without zone, and seconds since 1970, which know no daylight saving."""

    local: datetime
    utc_s: float


class Progress(msgspec.Struct, frozen=True, kw_only=True):
    """The place in a show at a moment."""

    item: int = 0
    elapsed_s: float = 0.0  # since the item began
    seen: datetime  # local time until which items of a fixed time have started
    utc_s: float


class ItemStart(NamedTuple):
    """A start by the clock."""

    at: datetime
    item: int


def clock_now() -> ShowClock:
    """The clock of this computer."""
    now = datetime.now().astimezone()
    return ShowClock(now.replace(tzinfo=None), now.timestamp())


def begin(show: Show, now: ShowClock) -> Progress:
    """The progress of a show that begins now: where it would be by the clock of today."""
    midnight = now.local.replace(hour=0, minute=0, second=0, microsecond=0)
    item, elapsed_s = 0, 0.0
    if due := _latest_start(show, midnight - timedelta(microseconds=1), now.local):
        item, elapsed_s = due.item, (now.local - due.at).total_seconds()
    item, elapsed_s = _walk(show, item, elapsed_s)
    return Progress(item=item, elapsed_s=elapsed_s, seen=now.local, utc_s=now.utc_s)


def advance(
    show: Show, before: Progress, now: ShowClock, elapsed_s: float, cue: bool = False
) -> Progress:
    """The progress `elapsed_s` later, by a clock that does not jump; on a `cue` the next item.

    A jump forward starts the item that the clock has passed. A jump back starts nothing: times that
    come again start their items again. An hour that comes twice in autumn starts them once.
    """
    back = jump_s(before, now, elapsed_s) < -JUMP_S
    seen = now.local if back else max(before.seen, now.local)
    due = None if back else _latest_start(show, before.seen, seen)
    if due:
        item, passed = _walk(show, due.item, max((now.local - due.at).total_seconds(), 0.0))
    elif cue and (following := next_item(show, before.item)) is not None:
        item, passed = following, 0.0
    else:
        item, passed = _walk(show, before.item, before.elapsed_s + elapsed_s)
    return Progress(item=item, elapsed_s=passed, seen=seen, utc_s=now.utc_s)


def resume(show: Show, saved: Progress, now: ShowClock) -> Progress:
    """The progress after a time without power: the saved one, or by the clock of a later item."""
    if not 0 <= saved.item < len(show.item) or saved.seen.date() != now.local.date():
        return begin(show, now)
    if now.local < saved.seen:  # the clock has lost its battery, or was set
        return msgspec.structs.replace(saved, seen=now.local, utc_s=now.utc_s)
    return advance(show, saved, now, 0.0)


def jump_s(before: Progress, now: ShowClock, elapsed_s: float) -> float:
    """How far the clock was set forward, s; below 0: back."""
    return now.utc_s - before.utc_s - elapsed_s


def next_item(show: Show, item: int) -> int | None:
    """The item that follows; None after the last of a show that does not repeat."""
    if item + 1 < len(show.item):
        return item + 1
    return 0 if show.repeat else None


def waits_for(show: Show, progress: Progress) -> str:
    """The start of the next item: "cue", a time, or the seconds left; empty if there is none."""
    following = next_item(show, progress.item)
    if following is None:
        return ""
    start = show.item[following].start
    for_s = show.item[progress.item].for_s
    if start == AFTER:
        return "" if for_s is None else f"{max(for_s - progress.elapsed_s, 0.0):.0f} s"
    return start


def timetable(show: Show) -> Iterator[tuple[str, int]]:
    """The start of each item, as far as a day's clock tells it: a time, "cue" or "after …"."""
    at: float | None = None  # minutes, known after an item of a fixed time
    for number, one in enumerate(show.item):
        before = show.item[number - 1] if number else None
        if one.minute is not None:
            at = float(one.minute)
            text = clock_text(one.minute)
        elif one.start == CUE:
            at, text = None, "on cue"
        elif at is not None and before is not None and before.for_s is not None:
            at += before.for_s / 60.0
            text = clock_text(int(at))
        else:
            text = "first" if before is None else f"after item {number}"
        yield text, number


def _walk(show: Show, item: int, elapsed_s: float) -> tuple[int, float]:
    """Go on over items whose time is over, if the next one starts after them."""
    cycle = sum(one.for_s or 0.0 for one in show.item)
    if cycle and show.repeat and all(one.start == AFTER and one.for_s for one in show.item):
        elapsed_s %= cycle
    for_s = show.item[item].for_s
    following = next_item(show, item)
    while for_s is not None and elapsed_s >= for_s and following is not None:
        if show.item[following].start != AFTER:
            break
        item, elapsed_s = following, elapsed_s - for_s
        for_s, following = show.item[item].for_s, next_item(show, item)
    return item, elapsed_s


def _latest_start(show: Show, after: datetime, until: datetime) -> ItemStart | None:
    """The last start by the clock after one local time and until another, at most a day back."""
    found = None
    after = max(after, until - DAY)
    midnight = until.replace(hour=0, minute=0, second=0, microsecond=0)
    for number, one in enumerate(show.item):
        if one.minute is None:
            continue
        for day in (midnight - DAY, midnight):
            at = day + timedelta(minutes=one.minute)
            if after < at <= until and (found is None or at > found.at):
                found = ItemStart(at, number)
    return found
