"""Edits of a show's file: what they change, keep and refuse."""

import pytest

from subsea.base.errors import UserError
from subsea.stage.opening_hours import SpecialDay
from subsea.stage.show_edit import add_special_day, edit_item, remove_special_day, special_day
from subsea.stage.show_file import load_show, show_path

SHOW = """# A show of a test
title = "two"   # in a hall
[[special_day]]
title = "Carnival"  # each year
yearly = "02-16"
[[item]]
scenario = "peaceful"   # first
for_s = 60  # a minute
[[item]]
scenario = "schooling"
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "show.toml"
    path.write_text(SHOW)
    return path


def test_keys_of_items_change_and_all_else_stays(file):
    show = edit_item(file, 0, "for_s", "90.5")
    assert show.item[0].for_s == 90.5 and load_show(file) == show
    assert file.read_text() == SHOW.replace("60 ", "90.5 ")
    assert edit_item(file, 1, "start", "10:30").item[1].minute == 630
    assert edit_item(file, 1, "caption", "123").item[1].caption == "123"
    both = edit_item(file, 1, "caption", '{ de = "Hallo", en = "Hello" }')
    assert both.item[1].caption_in("de") == "Hallo"
    assert edit_item(file, 1, "days", '["Carnival"]').item[1].days == ["Carnival"]
    assert edit_item(file, 1, "start", "").item[1].start == "after"
    assert "# A show of a test" in file.read_text() and "# first" in file.read_text()


@pytest.mark.parametrize(
    ("number", "key", "value", "message"),
    [
        (0, "for_s", "", "expected `for_s`"),
        (0, "for_s", "long", "expected a number"),
        (1, "start", "25:00", "expected 'after', 'cue'"),
        (1, "start", "01:00:00:00", r"expected a table \[timecode\]"),
        (1, "tour", "nowhere", "unknown tour 'nowhere'"),
        (1, "days", '["someday"]', "unknown day 'someday'"),
        (1, "scenario", "preying", "cannot be edited here"),
        (7, "caption", "x", "item 8: expected 1 to 2"),
    ],
)
def test_edits_that_cannot_be_played_leave_the_file(file, number, key, value, message):
    with pytest.raises(UserError, match=message):
        edit_item(file, number, key, value)
    assert file.read_text() == SHOW
    assert [path.name for path in file.parent.iterdir()] == ["show.toml"]


def test_special_days_come_and_go(file):
    show = add_special_day(file, special_day("2026-12-24", "Christmas", "closed", 3))
    assert show.special_day[1].when == "2026-12-24, 3 days"
    show = add_special_day(file, special_day("12-31", "", "10:00-12:00, 20:00-02:00", 1))
    assert show.special_day[2].hours == ["10:00-12:00", "20:00-02:00"]
    assert file.read_text().startswith(SHOW)
    show = remove_special_day(file, 1)
    assert [day.title for day in show.special_day] == ["Carnival", ""]
    assert "# each year" in file.read_text()
    with pytest.raises(UserError, match="special day 3: expected 1 to 2"):
        remove_special_day(file, 2)
    for when, hours in (("2026-13-01", "closed"), ("soon", "closed"), ("12-24", "shut")):
        with pytest.raises(UserError):
            special_day(when, "", hours, 1)


def test_a_day_that_items_name_is_not_removed(file):
    edit_item(file, 1, "days", '["Carnival"]')
    with pytest.raises(UserError, match="unknown day 'Carnival'"):
        remove_special_day(file, 0)


def test_shipped_shows_are_not_edited():
    with pytest.raises(UserError, match="copy it to a file of your own"):
        add_special_day(show_path("go-fish"), SpecialDay(easter=0))
