"""Read a show: a file of items, one after the other, by the clock or on cue.

The moment of a show is a pure function of the clock and the moment before. Items last by the time
that passes, so that a clock that jumps shortens none. The clock starts items of a fixed time, each
once a day.
"""

import hashlib
import re
from collections.abc import Iterator
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec

from subsea.base.errors import UserError
from subsea.base.files import file_hash
from subsea.base.system import is_path, resource_names, resource_path, unknown_name
from subsea.base.toml_files import error_at, load_toml
from subsea.dive.directed_camera import check_tour
from subsea.dive.ride import MOST_PAN_DEG, MOST_TILT_DEG
from subsea.frame.diagrams import chosen_diagrams
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario
from subsea.scenario.shoals import find_fish

DAYS = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
CLOSED = "closed"
DAY_MIN = 24 * 60
_TIME = re.compile(r"([01]?\d|2[0-4]):([0-5]\d)")

Span = tuple[int, int]  # minutes after midnight: open from, until before; beyond 24:00 at night


class OpeningHours(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Texts such as ``10:00-17:30`` or several of them; a day that is not named is closed."""

    monday: str | list[str] = CLOSED
    tuesday: str | list[str] = CLOSED
    wednesday: str | list[str] = CLOSED
    thursday: str | list[str] = CLOSED
    friday: str | list[str] = CLOSED
    saturday: str | list[str] = CLOSED
    sunday: str | list[str] = CLOSED

    def __post_init__(self) -> None:
        """Refuse texts that are not spans."""
        for day in DAYS:
            try:
                _spans(getattr(self, day))
            except ValueError as fault:
                raise ValueError(f"{day}: {fault}") from None


def minutes_of(text: str) -> int:
    """Minutes after midnight of a time such as ``10:30``; 24:00 is the end of a day."""
    time = _TIME.fullmatch(text.strip())
    minutes = 60 * int(time[1]) + int(time[2]) if time else DAY_MIN + 1
    if minutes > DAY_MIN:
        raise ValueError(f"{text!r}: expected a time of the day such as 10:30")
    return minutes


def spans_on(hours: OpeningHours, day: date) -> tuple[Span, ...]:
    """The spans that begin on a day."""
    return _spans(getattr(hours, DAYS[day.weekday()]))


def is_open(hours: OpeningHours | None, at: datetime) -> bool:
    """True at a local time within the hours; without hours, always."""
    if hours is None:
        return True
    day = day_of(hours, at)
    minute = 60 * at.hour + at.minute + DAY_MIN * (at.date() - day).days
    return any(begin <= minute < end for begin, end in spans_on(hours, day))


def day_of(hours: OpeningHours | None, at: datetime) -> date:
    """Find the day of the show at a local time: a night is part of the evening before."""
    before = at.date() - timedelta(days=1)
    minute = 60 * at.hour + at.minute + DAY_MIN
    late = hours is not None and any(minute < end for _, end in spans_on(hours, before))
    return before if late else at.date()


def hours_text(hours: OpeningHours | None, day: date) -> str:
    """The hours of a day in words."""
    if hours is None:
        return "always open"
    spans = ", ".join(f"{clock_text(a)} to {clock_text(b)}" for a, b in spans_on(hours, day))
    return f"open {spans}" if spans else CLOSED


def clock_text(minutes: int) -> str:
    """A time of the day, such as 10:30."""
    minutes -= DAY_MIN if minutes > DAY_MIN else 0
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def _spans(texts: str | list[str]) -> tuple[Span, ...]:
    if texts == CLOSED:
        return ()
    spans: list[Span] = []
    for text in [texts] if isinstance(texts, str) else texts:
        first, dash, last = text.partition("-")
        if not dash:
            raise ValueError(f"{text!r}: expected hours such as 10:00-17:30, or {CLOSED!r}")
        begin, end = minutes_of(first), minutes_of(last)
        end += DAY_MIN if end <= begin else 0  # past midnight
        if spans and begin < spans[-1][1]:
            raise ValueError(f"{text!r}: expected hours one after the other")
        spans.append((begin, end))
    return tuple(spans)


SHIPPED = "assets/shows"  # folder of shipped shows
AFTER, CUE = "after", "cue"
MOST_ITEMS = 200

Seconds = Annotated[float, msgspec.Meta(ge=1, le=86400)]
Fade = Annotated[float, msgspec.Meta(ge=0, le=30)]
Pan = Annotated[float, msgspec.Meta(ge=-MOST_PAN_DEG, le=MOST_PAN_DEG)]
Tilt = Annotated[float, msgspec.Meta(ge=-MOST_TILT_DEG, le=MOST_TILT_DEG)]
Words = Annotated[str, msgspec.Meta(max_length=300)]


class ShowItem(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A part of a show."""

    scenario: Annotated[str, msgspec.Meta(min_length=1, max_length=500)] | None = None
    tour: Annotated[str, msgspec.Meta(min_length=1, max_length=100)] | None = None
    start: str = AFTER  # or CUE, or a time of the day
    for_s: Seconds | None = None
    caption: Words = ""
    caption_s: Seconds | None = None
    fade_s: Fade | None = None  # into black, and out of it again; None: that of the show
    show: list[str] = []  # diagrams over the picture
    wireframe: bool = False  # draw the edges of triangles
    bodies: bool = True  # False: the fishes are hidden, and only their diagrams are seen
    follow: Annotated[str, msgspec.Meta(min_length=1, max_length=100)] | None = None
    eyes: Annotated[str, msgspec.Meta(min_length=1, max_length=100)] | None = None
    # Degrees right and up from where this fish heads; of a followed one only right, round it.
    gaze_deg: tuple[Pan, Tilt] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse an invalid start, unknown diagrams, and two cameras."""
        try:
            chosen_diagrams(",".join(self.show))
        except UserError as fault:
            raise ValueError(f"`show`: {fault}") from None
        cameras = [key for key in ("tour", "follow", "eyes") if getattr(self, key) is not None]
        if len(cameras) > 1:
            raise ValueError(f"expected one of {' and '.join(f'`{key}`' for key in cameras)}")
        if self.start not in (AFTER, CUE):
            try:
                minutes_of(self.start)
            except ValueError:
                raise ValueError(
                    f"`start` is {self.start!r}, expected 'after', 'cue' or a time such as '10:30'"
                ) from None

    @property
    def minute(self) -> int | None:
        """Minutes after midnight at which it starts; None: not by the clock."""
        return None if self.start in (AFTER, CUE) else minutes_of(self.start) % (24 * 60)

    @property
    def own_view(self) -> str | None:
        """The first key that changes how one computer draws the sea; None without one."""
        keys = ("show", "wireframe", "follow", "eyes")
        changed = (key for key in keys if getattr(self, key))
        return next(changed, None if self.bodies else "bodies")


class Show(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A whole show."""

    title: Words = ""
    repeat: bool = True  # the first item follows the last
    fade_s: Fade = 1.0
    hours: OpeningHours | None = None
    item: Annotated[list[ShowItem], msgspec.Meta(min_length=1, max_length=MOST_ITEMS)]


def shipped_shows() -> list[str]:
    """The names of shipped shows, sorted."""
    return resource_names(SHIPPED, ".toml")


def show_path(name: str) -> Path:
    """The file of a shipped show, or the path `name`; a UserError for an unknown name."""
    if is_path(name, ".toml"):
        return Path(name)
    if name not in (known := shipped_shows()):
        raise unknown_name("show", name, known, ".toml")
    return resource_path(SHIPPED) / f"{name}.toml"


def load_show(path: Path) -> Show:
    """Read a show; a UserError names line and key. Its scenarios are not read: see `faults`."""
    show = load_toml(path, Show)
    if show.item[0].scenario is None:
        raise error_at(path, "item[0]", "`item[0]`: the first item needs a `scenario`")
    for k, (item, after) in enumerate(zip(show.item, show.item[1:], strict=False)):
        if item.for_s is None and after.start == AFTER:
            message = (
                f"`item[{k}]`: expected `for_s`, as item {k + 2} starts after it; or a `start` of "
                f"item {k + 2}"
            )
            raise error_at(path, f"item[{k}]", message)
    starts = [item.minute for item in show.item]
    for k, minute in enumerate(starts):
        if minute is not None and minute in starts[:k]:
            raise error_at(path, f"item[{k}].start", f"two items start at {show.item[k].start}")
    return show


def show_digest(path: Path) -> str:
    """A digest of a show's file."""
    return hashlib.sha256(file_hash(path).encode()).hexdigest()[:16]


def scenario_name(show: Show, path: Path, number: int) -> str:
    """The scenario of an item: its own, or that of the nearest one before it.

    A path is relative to the file of the show.
    """
    name = next(item.scenario for item in reversed(show.item[: number + 1]) if item.scenario)
    return str(path.parent / name) if is_path(name, ".toml") else name


def open_item(show: Show, path: Path, number: int) -> tuple[Scenario, Path]:
    """The scenario of an item and its file; a UserError if that or the tour is missing."""
    scenario, file, _ = load_scenario(scenario_name(show, path, number))
    item = show.item[number]
    if item.tour is not None:
        check_tour(scenario, item.tour)
    if (fish := item.eyes or item.follow) is not None:
        find_fish(fish, scenario)
    return scenario, file


def check_for_cluster(show: Show, path: Path) -> None:
    """Refuse what several computers cannot play together, with line and key.

    Nodes open scenarios by name, and a submarine that is under way cannot be put elsewhere.
    """
    for k, item in enumerate(show.item):
        if item.scenario is not None and is_path(item.scenario, ".toml"):
            message = (
                f"{item.scenario!r} is a path, expected a name that all computers of a cluster know"
            )
            raise error_at(path, f"item[{k}].scenario", f"`item[{k}].scenario`: {message}")
        if (key := item.own_view) is not None:
            message = "it is for one computer: others would draw another picture"
            raise error_at(path, f"item[{k}].{key}", f"`item[{k}].{key}`: {message}")
        if item.tour not in (None, AUTOPILOT, DIRECTED):
            message = f"{item.tour!r} begins elsewhere; in a cluster expected "
            message += f"{AUTOPILOT!r} or {DIRECTED!r}"
            raise error_at(path, f"item[{k}].tour", f"`item[{k}].tour`: {message}")


def faults(show: Show, path: Path) -> Iterator[tuple[int, UserError]]:
    """Items whose scenario or tour is missing or faulty."""
    for number in range(len(show.item)):
        try:
            open_item(show, path, number)
        except UserError as fault:
            key = f"item[{number}]"
            if str(fault).startswith(("unknown tour", "tour ")):
                key += ".tour"
            elif str(fault).startswith(("unknown fish", "no fish", "fish ")):
                key += ".eyes" if show.item[number].eyes else ".follow"
            else:
                key += ".scenario"
            yield number, error_at(path, key, f"item {number + 1}: {fault}")


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


def clock_now() -> ShowClock:
    """The clock of this computer."""
    now = datetime.now().astimezone()
    return ShowClock(now.replace(tzinfo=None), now.timestamp())


def begin(show: Show, now: ShowClock) -> Progress:
    """The progress of a show that begins now: where it would be by the clock of its day."""
    midnight = datetime.combine(day_of(show.hours, now.local), time())
    item, elapsed_s = 0, 0.0
    if due := _latest_start(show, midnight - timedelta(microseconds=1), now.local):
        item, elapsed_s = due[1], (now.local - due[0]).total_seconds()
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
        item, passed = _walk(show, due[1], max((now.local - due[0]).total_seconds(), 0.0))
    elif cue and (following := next_item(show, before.item)) is not None:
        item, passed = following, 0.0
    else:
        item, passed = _walk(show, before.item, before.elapsed_s + elapsed_s)
    return Progress(item=item, elapsed_s=passed, seen=seen, utc_s=now.utc_s)


def resume(show: Show, saved: Progress, now: ShowClock) -> Progress:
    """The progress after a time without power: the saved one, or by the clock of a later item."""
    days = {day_of(show.hours, at) for at in (saved.seen, now.local)}
    if not 0 <= saved.item < len(show.item) or len(days) > 1:
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
    for number, item in enumerate(show.item):
        before = show.item[number - 1] if number else None
        if item.minute is not None:
            at = float(item.minute)
            text = clock_text(item.minute)
        elif item.start == CUE:
            at, text = None, "on cue"
        elif at is not None and before is not None and before.for_s is not None:
            at += before.for_s / 60.0
            text = clock_text(int(at))
        else:
            text = "first" if before is None else f"after item {number}"
        yield text, number


def _walk(show: Show, item: int, elapsed_s: float) -> tuple[int, float]:
    """Go on over items whose time is over, if the next one starts after them."""
    cycle = sum(each.for_s or 0.0 for each in show.item)
    if cycle and show.repeat and all(each.start == AFTER and each.for_s for each in show.item):
        elapsed_s %= cycle
    for_s = show.item[item].for_s
    following = next_item(show, item)
    while for_s is not None and elapsed_s >= for_s and following is not None:
        if show.item[following].start != AFTER:
            break
        item, elapsed_s = following, elapsed_s - for_s
        for_s, following = show.item[item].for_s, next_item(show, item)
    return item, elapsed_s


def _latest_start(show: Show, after: datetime, until: datetime) -> tuple[datetime, int] | None:
    """Find the last start by the clock after one local time and until another, and its item.

    Starts more than a day back do not count.
    """
    midnight = until.replace(hour=0, minute=0, second=0, microsecond=0)
    starts = [
        (day + timedelta(minutes=item.minute), number)
        for number, item in enumerate(show.item)
        for day in (midnight - DAY, midnight)
        if item.minute is not None
    ]
    since = max(after, until - DAY)
    return max((start for start in starts if since < start[0] <= until), default=None)
