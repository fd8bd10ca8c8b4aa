"""Opening hours, by minutes that are counted one by one."""

from datetime import datetime, timedelta

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.show_file import DAYS, OpeningHours, clock_text, hours_text, is_open

HOURS = OpeningHours(
    monday="10:00-17:30",
    friday=["09:00-12:00", "18:00-02:00"],
    saturday="closed",
    sunday="00:00-24:00",
)


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
    assert is_open(None, datetime(2026, 1, 1))
    assert hours_text(None, datetime(2026, 1, 1)) == "always open"


@given(st.integers(0, 1439), st.integers(0, 1439), st.integers(0, 7 * 1440 - 1))
def test_a_day_is_open_for_as_long_as_its_hours(begin, end, minute):
    text = f"{clock_text(begin)}-{clock_text(end)}"
    hours = OpeningHours(**dict.fromkeys(DAYS, text))
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
