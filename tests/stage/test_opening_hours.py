"""Opening hours, by minutes that are counted one by one."""

from datetime import date, datetime, timedelta

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.opening_hours import (
    DAYS,
    Calendar,
    OpeningHours,
    SpecialDay,
    clock_text,
    easter_of,
    hours_text,
    is_open,
)

HOURS = Calendar(OpeningHours(
    monday="10:00-17:30",
    friday=["09:00-12:00", "18:00-02:00"],
    saturday="closed",
    sunday="00:00-24:00",
))  # fmt: skip


@pytest.mark.parametrize(
    ("at", "open_"),
    [
        ("2026-11-23 09:59", False),  # a Monday
        ("2026-11-23 10:00", True),
        ("2026-11-23 17:29", True),
        ("2026-11-23 17:30", False),
        ("2026-11-24 12:00", False),  # not named
        ("2026-11-27 12:00", False),
        ("2026-11-27 23:59", True),
        ("2026-11-28 01:59", True),  # a closed Saturday, but Friday's night
        ("2026-11-28 02:00", False),
        ("2026-11-29 00:00", True),
        ("2026-11-29 23:59", True),
    ],
)
def test_hours_of_weekdays_and_past_midnight(at, open_):
    assert is_open(HOURS, datetime.fromisoformat(at)) == open_


def test_without_hours_it_is_always_open():
    assert is_open(Calendar(), datetime(2026, 1, 1))
    assert hours_text(Calendar(), date(2026, 1, 1)) == "always open"


@given(st.integers(0, 1439), st.integers(0, 1439), st.integers(0, 7 * 1440 - 1))
def test_a_day_is_open_for_as_long_as_its_hours(begin, end, minute):
    text = f"{clock_text(begin)}-{clock_text(end)}"
    hours = Calendar(OpeningHours(**dict.fromkeys(DAYS, text)))
    at = datetime(2026, 11, 23) + timedelta(minutes=minute)
    within = begin <= minute % 1440 < end if begin < end else not end <= minute % 1440 < begin
    assert is_open(hours, at) == within


@pytest.mark.parametrize(
    "text", ["10", "10:00", "25:00-26:00", "10:60-11:00", "24:30-25:00", "", "ten-eleven"]
)
def test_odd_hours_are_refused_with_the_day(text):
    with pytest.raises(msgspec.ValidationError, match=r"monday: .*expected"):
        msgspec.convert({"monday": text}, OpeningHours)


def test_hours_that_overlap_are_refused():
    with pytest.raises(msgspec.ValidationError, match="one after the other"):
        msgspec.convert({"monday": ["10:00-12:00", "11:00-13:00"]}, OpeningHours)


CHRISTMAS = SpecialDay(title="Christmas", yearly="12-24", days=3, hours="closed")
NEW_YEAR = SpecialDay(title="New Year", yearly="12-30", days=5, hours="18:00-02:00")
GOOD_FRIDAY = SpecialDay(title="Good Friday", easter=-2, hours=["12:00-14:00"])
GALA = SpecialDay(title="Gala", date=date(2026, 12, 31))
SPECIAL = Calendar(OpeningHours(thursday="10:00-12:00"), (CHRISTMAS, NEW_YEAR, GOOD_FRIDAY, GALA))


@pytest.mark.parametrize(
    ("at", "open_"),
    [
        ("2026-12-17 11:00", True),  # a Thursday
        ("2026-12-24 11:00", False),
        ("2026-12-31 11:00", False),  # the Gala keeps the hours of New Year
        ("2026-12-31 23:00", True),
        ("2027-01-01 01:00", True),
        ("2027-01-03 19:00", True),  # the fifth day is in the next year
        ("2027-01-04 19:00", False),
        ("2026-04-03 13:00", True),  # a Friday without hours
        ("2026-04-10 13:00", False),
    ],
)
def test_special_days_come_before_the_week(at, open_):
    assert is_open(SPECIAL, datetime.fromisoformat(at)) == open_


def test_a_show_without_hours_is_open_but_on_special_days():
    always = Calendar(None, (CHRISTMAS,))
    assert is_open(always, datetime(2026, 12, 23, 23, 59))
    assert not is_open(always, datetime(2026, 12, 26, 12, 0))
    assert hours_text(always, date(2026, 12, 25)) == "closed (Christmas)"
    assert SPECIAL.names_of(date(2026, 12, 31)) == ("thursday", "New Year", "Gala")


@pytest.mark.parametrize(
    "day", ["1961-04-02", "2000-04-23", "2008-03-23", "2011-04-24", "2026-04-05", "2038-04-25"]
)
def test_easter_is_where_calendars_have_it(day):
    known = date.fromisoformat(day)
    assert easter_of(known.year) == known


def test_a_leap_day_is_missing_in_other_years():
    leap = SpecialDay(yearly="02-29", hours="closed")
    assert leap.holds(date(2028, 2, 29))
    assert not any(leap.holds(date(2027, 2, 1) + timedelta(days=k)) for k in range(60))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({}, "expected one of `date`, `yearly` and `easter`"),
        ({"yearly": "12-24", "easter": 1}, "expected one of"),
        ({"yearly": "24-12"}, "month and day such as 12-24"),
        ({"yearly": "02-30"}, "month and day"),
        ({"date": "tomorrow"}, "date"),
        ({"yearly": "12-24", "hours": "shut"}, "`hours`: 'shut': expected hours"),
    ],
)
def test_odd_special_days_are_refused(content, message):
    with pytest.raises(msgspec.ValidationError, match=message):
        msgspec.convert(content, SpecialDay)
