"""Opening hours of an exhibition: spans of the day for each day of the week."""

import re
from datetime import date, datetime, timedelta

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
    found = _TIME.fullmatch(text.strip())
    minutes = 60 * int(found[1]) + int(found[2]) if found else DAY_MIN + 1
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
    minute = 60 * at.hour + at.minute
    before = spans_on(hours, at.date() - timedelta(days=1))
    return any(begin <= minute < end for begin, end in spans_on(hours, at.date())) or any(
        minute + DAY_MIN < end for _, end in before
    )


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
    found: list[Span] = []
    for text in [texts] if isinstance(texts, str) else texts:
        first, dash, last = text.partition("-")
        if not dash:
            raise ValueError(f"{text!r}: expected hours such as 10:00-17:30, or {CLOSED!r}")
        begin, end = minutes_of(first), minutes_of(last)
        end += DAY_MIN if end <= begin else 0  # past midnight
        if found and begin < found[-1][1]:
            raise ValueError(f"{text!r}: expected hours one after the other")
        found.append((begin, end))
    return tuple(found)
