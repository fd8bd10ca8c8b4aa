"""Read a show: a file of items, one after the other, by the clock or on cue.

The moment of a show is a pure function of the clock and the moment before. Items last by the time
that passes, so that a clock that jumps shortens none. The clock starts items of a fixed time, each
once a day.
"""

import hashlib
from collections.abc import Iterable, Iterator
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec

from subsea.base.errors import UserError, unknown
from subsea.base.files import file_hash
from subsea.base.language import LANGUAGES, language, translated
from subsea.base.system import is_path, resource_names, resource_path, unknown_name
from subsea.base.toml_files import error_at, load_toml
from subsea.dive.directed_camera import check_tour
from subsea.dive.presented import OverlayFile
from subsea.dive.ride import MOST_PAN_DEG, MOST_TILT_DEG
from subsea.frame.diagrams import chosen_diagrams
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario
from subsea.scenario.shoals import find_fish
from subsea.stage.cues.tables import MidiIn, OscOut, TimecodeIn, check_message
from subsea.stage.cues.timecode import parsed_label, seconds_of
from subsea.stage.opening_hours import (
    DAYS,
    Calendar,
    OpeningHours,
    SpecialDay,
    clock_text,
    day_of,
    minutes_of,
)
from subsea.stage.theatre.theatre_file import File
from subsea.view.surround import ALL_ROUND

SHIPPED = "assets/shows"  # folder of shipped shows
AFTER, CUE = "after", "cue"
MOST_ITEMS, MOST_SPECIAL_DAYS = 200, 400

Seconds = Annotated[float, msgspec.Meta(ge=1, le=86400)]
Fade = Annotated[float, msgspec.Meta(ge=0, le=30)]
Pan = Annotated[float, msgspec.Meta(ge=-MOST_PAN_DEG, le=MOST_PAN_DEG)]
Tilt = Annotated[float, msgspec.Meta(ge=-MOST_TILT_DEG, le=MOST_TILT_DEG)]
Words = Annotated[str, msgspec.Meta(max_length=300)]


class FisheyeOverlay(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A picture over the sea: an equidistant fisheye with the front at its foot, as of a dome."""

    file: File  # PNG with opacity, relative to the show
    tilt_deg: Annotated[float, msgspec.Meta(ge=0, le=90)] = ALL_ROUND.tilt_deg  # to the front
    angle_deg: Annotated[float, msgspec.Meta(ge=30, le=360)] = ALL_ROUND.dome_deg

    @property
    def picture(self) -> OverlayFile:
        """Its file and how it lies over the sea."""
        return OverlayFile(self.file, self.tilt_deg, self.angle_deg)


class ShowItem(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A part of a show."""

    scenario: Annotated[str, msgspec.Meta(min_length=1, max_length=500)] | None = None
    tour: Annotated[str, msgspec.Meta(min_length=1, max_length=100)] | None = None
    start: str = AFTER  # or CUE, a time of the day, or a timecode
    days: list[str] = []  # weekdays and titles of special days; empty: all
    for_s: Seconds | None = None
    caption: Words | dict[str, Words] = ""  # or by language
    caption_s: Seconds | None = None
    fade_s: Fade | None = None  # into black, and out of it again; None: that of the show
    overlay: FisheyeOverlay | None = None
    osc: Annotated[list[Words], msgspec.Meta(max_length=50)] = []  # messages when it begins
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
        if self.start not in (AFTER, CUE) and not self.by_timecode:
            try:
                minutes_of(self.start)
            except ValueError:
                raise ValueError(
                    f"`start` is {self.start!r}, expected 'after', 'cue', a time such as '10:30' "
                    "or a timecode such as '01:00:00:00'"
                ) from None
        if isinstance(self.caption, dict):
            _check_languages("caption", self.caption)
        for message in self.osc:
            try:
                check_message(message)
            except ValueError as fault:
                raise ValueError(f"`osc`: {fault}") from None

    @property
    def by_timecode(self) -> bool:
        """True if a timecode starts it."""
        try:
            parsed_label(self.start)
        except ValueError:
            return False
        return True

    @property
    def minute(self) -> int | None:
        """Minutes after midnight at which it starts; None: not by the clock."""
        if self.start in (AFTER, CUE) or self.by_timecode:
            return None
        return minutes_of(self.start) % (24 * 60)

    def caption_in(self, code: str) -> str:
        """The caption in a language: its own, else the English one, else the first."""
        if isinstance(self.caption, str):
            return translated(self.caption, code)
        others = self.caption.get("en") or next(iter(self.caption.values()), "")
        return self.caption.get(code) or others

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
    languages: list[str] = []  # of captions, one after the other; empty: that of the dive
    hours: OpeningHours | None = None
    special_day: Annotated[list[SpecialDay], msgspec.Meta(max_length=MOST_SPECIAL_DAYS)] = []
    osc: OscOut | None = None
    timecode: TimecodeIn | None = None
    midi: MidiIn | None = None
    item: Annotated[list[ShowItem], msgspec.Meta(min_length=1, max_length=MOST_ITEMS)]

    def __post_init__(self) -> None:
        """Refuse unknown languages."""
        _check_languages("languages", self.languages)

    @property
    def calendar(self) -> Calendar:
        """When it is open."""
        return Calendar(self.hours, tuple(self.special_day))

    def captions_of(self, number: int) -> list[str]:
        """The captions of an item, to be shown one after the other."""
        codes = self.languages or [language()]
        return list(dict.fromkeys(self.item[number].caption_in(code) for code in codes))

    def is_on(self, number: int, day: date) -> bool:
        """True if an item is on at a day."""
        days = self.item[number].days
        return not days or any(name in days for name in self.calendar.names_of(day))


def _check_languages(key: str, codes: Iterable[str]) -> None:
    for code in codes:
        if code not in LANGUAGES:
            raise ValueError(f"`{key}`: {code!r}, expected {', '.join(LANGUAGES)}")


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
    for k, item in enumerate(show.item):
        same = [one for one in show.item[:k] if item.start not in (AFTER, CUE)
                and one.start == item.start and _meet(one, item)]  # fmt: skip
        if same:
            raise error_at(path, f"item[{k}].start", f"two items start at {item.start}")
        if item.by_timecode and show.timecode is None:
            message = f"`start` is {item.start!r}, a timecode: expected a table [timecode]"
            raise error_at(path, f"item[{k}].start", message)
        if item.osc and show.osc is None:
            message = "`osc`: expected a table [osc] that says where messages go"
            raise error_at(path, f"item[{k}].osc", message)
        if k and item.scenario is None and item.days != show.item[k - 1].days:
            message = "an item of other days than the one before needs a `scenario`"
            raise error_at(path, f"item[{k}]", f"`item[{k}]`: {message}")
        known = [*DAYS, *(one.title for one in show.special_day if one.title)]
        for name in item.days:
            if name not in known:
                raise error_at(path, f"item[{k}].days", unknown("day", name, known).message)
    return show


def _meet(one: ShowItem, other: ShowItem) -> bool:
    """True if two items may be on at the same day."""
    return not one.days or not other.days or bool(set(one.days) & set(other.days))


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
    day = day_of(show.calendar, now.local)
    midnight = datetime.combine(day, time())
    item, elapsed_s = next((k for k in range(len(show.item)) if show.is_on(k, day)), 0), 0.0
    if due := _latest_start(show, midnight - timedelta(microseconds=1), now.local):
        item, elapsed_s = due[1], (now.local - due[0]).total_seconds()
    item, elapsed_s = _walk(show, item, elapsed_s, day)
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
    day = day_of(show.calendar, now.local)
    over = cue or not show.is_on(before.item, day)  # its days are over
    if due:
        item, passed = _walk(show, due[1], max((now.local - due[0]).total_seconds(), 0.0), day)
    elif over and (following := next_item(show, before.item, day)) is not None:
        item, passed = following, 0.0
    else:
        item, passed = _walk(show, before.item, before.elapsed_s + elapsed_s, day)
    return Progress(item=item, elapsed_s=passed, seen=seen, utc_s=now.utc_s)


def resume(show: Show, saved: Progress, now: ShowClock) -> Progress:
    """The progress after a time without power: the saved one, or by the clock of a later item."""
    days = {day_of(show.calendar, at) for at in (saved.seen, now.local)}
    if not 0 <= saved.item < len(show.item) or len(days) > 1:
        return begin(show, now)
    if now.local < saved.seen:  # the clock has lost its battery, or was set
        return msgspec.structs.replace(saved, seen=now.local, utc_s=now.utc_s)
    return advance(show, saved, now, 0.0)


def jump_s(before: Progress, now: ShowClock, elapsed_s: float) -> float:
    """How far the clock was set forward, s; below 0: back."""
    return now.utc_s - before.utc_s - elapsed_s


def next_item(show: Show, item: int, day: date) -> int | None:
    """The item of a day that follows; None after the last of a show that does not repeat."""
    later = range(item + 1, len(show.item))
    order = [*later, *range(item + 1)] if show.repeat else later
    return next((number for number in order if show.is_on(number, day)), None)


def place_at(show: Show, time_s: float, day: date) -> tuple[int, float] | None:
    """The item of a day at a timecode, and the seconds since it began; None before the first."""
    if show.timecode is None:
        return None
    starts = [
        (seconds_of(parsed_label(item.start), show.timecode.frames), number)
        for number, item in enumerate(show.item)
        if item.by_timecode and show.is_on(number, day)
    ]
    past = [start for start in starts if start[0] <= time_s]
    return _walk(show, max(past)[1], time_s - max(past)[0], day) if past else None


def waits_for(show: Show, progress: Progress) -> str:
    """The start of the next item: "cue", a time, or the seconds left; empty if there is none."""
    following = next_item(show, progress.item, day_of(show.calendar, progress.seen))
    if following is None:
        return ""
    start = show.item[following].start
    for_s = show.item[progress.item].for_s
    if start == AFTER:
        return "" if for_s is None else f"{max(for_s - progress.elapsed_s, 0.0):.0f} s"
    return start


def timetable(show: Show, day: date) -> Iterator[tuple[str, int]]:
    """The start of each item of a day, as far as its clock tells: a time, "cue" or "after …"."""
    at: float | None = None  # minutes, known after an item of a fixed time
    last: int | None = None
    for number, item in enumerate(show.item):
        if not show.is_on(number, day):
            continue
        before = None if last is None else show.item[last]
        if item.minute is not None:
            at = float(item.minute)
            text = clock_text(item.minute)
        elif item.start == CUE or item.by_timecode:
            at, text = None, "on cue" if item.start == CUE else item.start
        elif at is not None and before is not None and before.for_s is not None:
            at += before.for_s / 60.0
            text = clock_text(int(at))
        else:
            text = "first" if last is None else f"after item {last + 1}"
        yield text, number
        last = number


def _walk(show: Show, item: int, elapsed_s: float, day: date) -> tuple[int, float]:
    """Go on over items of a day whose time is over, if the next one starts after them."""
    those = [one for number, one in enumerate(show.item) if show.is_on(number, day)]
    cycle = sum(each.for_s or 0.0 for each in those)
    if cycle and show.repeat and all(each.start == AFTER and each.for_s for each in those):
        elapsed_s %= cycle
    for_s = show.item[item].for_s
    following = next_item(show, item, day)
    while for_s is not None and elapsed_s >= for_s and following is not None:
        if show.item[following].start != AFTER:
            break
        item, elapsed_s = following, elapsed_s - for_s
        for_s, following = show.item[item].for_s, next_item(show, item, day)
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
    due = (start for start in starts if since < start[0] <= until)
    on = (start for start in due if show.is_on(start[1], day_of(show.calendar, start[0])))
    return max(on, default=None)
