"""When a show is open: hours of the week, special days and closings.

A night belongs to the evening before: hours may end on the next day.
"""

import re
from datetime import date, datetime, timedelta
from typing import Annotated, NamedTuple

import msgspec

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


Day = date  # which a key of the next table is called like


class SpecialDay(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A day, or some days on end, that differ from the week: once, each year, or about Easter."""

    title: Annotated[str, msgspec.Meta(max_length=100)] = ""
    date: Day | None = None
    yearly: Annotated[str, msgspec.Meta(max_length=10)] | None = None  # month and day: 12-24
    easter: Annotated[int, msgspec.Meta(ge=-100, le=100)] | None = None  # days after its Sunday
    days: Annotated[int, msgspec.Meta(ge=1, le=366)] = 1
    hours: str | list[str] | None = None  # None: as on any day of the week

    def __post_init__(self) -> None:
        """Require one way to say when it is, and hours that can be read."""
        given = [self.date, self.yearly, self.easter]
        if sum(one is not None for one in given) != 1:
            raise ValueError("expected one of `date`, `yearly` and `easter`")
        if self.yearly is not None:
            _month_and_day(self.yearly)
        if self.hours is not None:
            try:
                _spans(self.hours)
            except ValueError as fault:
                raise ValueError(f"`hours`: {fault}") from None

    @property
    def when(self) -> str:
        """Its days in words."""
        if self.date is not None:
            text = self.date.isoformat()
        elif self.easter is not None:
            text = f"Easter {self.easter:+d}" if self.easter else "Easter"
        else:
            text = f"each {self.yearly}"
        return text if self.days == 1 else f"{text}, {self.days} days"

    def first_in(self, year: int) -> Day | None:
        """The first of its days in a year; None if it is in another, or the year has none."""
        if self.date is not None:
            return self.date if self.date.year == year else None
        if self.easter is not None:
            return easter_of(year) + timedelta(days=self.easter)
        month, day = _month_and_day(self.yearly or "")
        try:
            return date(year, month, day)
        except ValueError:  # February 29
            return None

    def holds(self, day: Day) -> bool:
        """True on its days."""
        firsts = (self.first_in(year) for year in (day.year - 1, day.year))
        return any(first is not None and 0 <= (day - first).days < self.days for first in firsts)


class Calendar(NamedTuple):
    """The hours of the week, None: always open; and days that differ, where later ones win."""

    hours: OpeningHours | None = None
    special: tuple[SpecialDay, ...] = ()

    def names_of(self, day: date) -> tuple[str, ...]:
        """The names of a day: its weekday, and the titles of special days."""
        titles = (one.title for one in self.special if one.title and one.holds(day))
        return DAYS[day.weekday()], *titles


def easter_of(year: int) -> date:
    """Find Easter Sunday of a year (Meeus, Jones and Butcher's algorithm)."""
    golden, century = year % 19, year // 100
    epact = (
        19 * golden + century - century // 4 - (century - (century + 8) // 25 + 1) // 3 + 15
    ) % 30
    weekday = (32 + 2 * (century % 4) + 2 * (year % 100 // 4) - epact - year % 4) % 7
    shift = (golden + 11 * epact + 22 * weekday) // 451
    month, day = divmod(epact + weekday - 7 * shift + 114, 31)
    return date(year, month, day + 1)


def spans_on(calendar: Calendar, day: date) -> tuple[Span, ...]:
    """The spans that begin on a day."""
    for special in reversed(calendar.special):
        if special.hours is not None and special.holds(day):
            return _spans(special.hours)
    if calendar.hours is None:
        return ((0, DAY_MIN),)
    return _spans(getattr(calendar.hours, DAYS[day.weekday()]))


def is_open(calendar: Calendar, at: datetime) -> bool:
    """True at a local time within the hours."""
    day = day_of(calendar, at)
    minute = 60 * at.hour + at.minute + DAY_MIN * (at.date() - day).days
    return any(begin <= minute < end for begin, end in spans_on(calendar, day))


def day_of(calendar: Calendar, at: datetime) -> date:
    """Find the day of the show at a local time: a night is part of the evening before."""
    before = at.date() - timedelta(days=1)
    minute = 60 * at.hour + at.minute + DAY_MIN
    late = any(minute < end for _, end in spans_on(calendar, before))
    return before if late else at.date()


def hours_text(calendar: Calendar, day: date) -> str:
    """The hours of a day in words, and its titles."""
    titles = calendar.names_of(day)[1:]
    about = f" ({', '.join(titles)})" if titles else ""
    spans = spans_on(calendar, day)
    if spans == ((0, DAY_MIN),):
        return f"open all day{about}" if calendar.hours or about else "always open"
    text = ", ".join(f"{clock_text(a)} to {clock_text(b)}" for a, b in spans)
    return f"open {text}{about}" if text else f"{CLOSED}{about}"


def _month_and_day(text: str) -> tuple[int, int]:
    """Read a month and a day such as ``12-24``; a ValueError for anything else."""
    found = re.fullmatch(r"(\d\d?)-(\d\d?)", text)
    month, day = (int(found[1]), int(found[2])) if found else (0, 0)
    try:
        date(2024, month, day)  # a leap year
    except ValueError:
        raise ValueError(f"`yearly` is {text!r}, expected month and day such as 12-24") from None
    return month, day


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
