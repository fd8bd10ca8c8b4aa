"""Shows by the clock and on cue, over clocks that jump."""

from datetime import datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.cues.tables import TimecodeIn
from subsea.stage.opening_hours import OpeningHours, SpecialDay
from subsea.stage.show_file import (
    Show,
    ShowClock,
    ShowItem,
    advance,
    begin,
    next_item,
    place_at,
    resume,
    timetable,
    waits_for,
)
from subsea.stage.show_player import ShowPlayer

NINE = datetime(2026, 11, 23, 9, 0)
MORNING = Show(
    item=[
        ShowItem(scenario="a", for_s=60.0),
        ShowItem(scenario="b", for_s=30.0),
        ShowItem(scenario="c", start="cue"),
        ShowItem(scenario="d", start="10:30", for_s=600.0),
        ShowItem(scenario="e"),
    ]
)


def clock(local, utc_s=None):
    return ShowClock(local, (local - NINE).total_seconds() if utc_s is None else utc_s)


def play(show, now, progress, seconds, step_s=1.0, **rest):
    """The progress after a time in which the clock is right."""
    for _ in range(round(seconds / step_s)):
        now = ShowClock(now.local + timedelta(seconds=step_s), now.utc_s + step_s)
        progress = advance(show, progress, now, step_s, **rest)
    return now, progress


def test_items_follow_each_other_a_cue_and_the_clock():
    now = clock(NINE)
    progress = begin(MORNING, now)
    assert (progress.item, progress.elapsed_s) == (0, 0.0)
    now, progress = play(MORNING, now, progress, 59)
    assert progress.item == 0 and waits_for(MORNING, progress) == "1 s"
    now, progress = play(MORNING, now, progress, 2)
    assert (progress.item, progress.elapsed_s) == (1, 1.0)
    now, progress = play(MORNING, now, progress, 3600)
    assert progress.item == 1 and waits_for(MORNING, progress) == "cue"
    progress = advance(MORNING, progress, now, 0.0, cue=True)
    assert (progress.item, waits_for(MORNING, progress)) == (2, "10:30")
    now, progress = play(MORNING, now, progress, 1800 - 62)
    assert progress.item == 2
    now, progress = play(MORNING, now, progress, 2)
    assert progress.item == 3 and progress.elapsed_s < 2.0
    now, progress = play(MORNING, now, progress, 601)
    assert progress.item == 4 and waits_for(MORNING, progress) == ""
    assert advance(MORNING, progress, now, 0.0, cue=True).item == 0


def test_a_show_that_does_not_repeat_stays_at_its_end():
    once = Show(repeat=False, item=[ShowItem(scenario="a", for_s=5.0)])
    now, progress = play(once, clock(NINE), begin(once, clock(NINE)), 60)
    assert (progress.item, progress.elapsed_s) == (0, 60.0)
    assert next_item(once, 0, NINE.date()) is None
    assert advance(once, progress, now, 0.0, cue=True).item == 0


@pytest.mark.parametrize(
    ("time", "item", "elapsed_s"),
    [("10:29", 0, 0.0), ("10:31", 3, 60.0), ("10:45", 4, 300.0), ("23:00", 4, 44400.0)],
)
def test_a_show_that_begins_late_is_where_the_clock_says(time, item, elapsed_s):
    now = datetime.fromisoformat(f"2026-11-23 {time}")
    progress = begin(MORNING, clock(now))
    assert (progress.item, progress.elapsed_s) == (item, elapsed_s)


@given(
    st.lists(st.tuples(st.floats(-90000, 90000), st.floats(0.0, 120.0)), max_size=30),
    st.integers(0, 1440),
)
def test_a_clock_that_jumps_never_shortens_an_item_of_a_show_without_times(jumps, minute):
    """Nothing but the time that passes counts."""
    show = Show(item=[ShowItem(scenario="a", for_s=100.0), ShowItem(scenario="b", for_s=50.0)])
    now = clock(NINE + timedelta(minutes=minute))
    progress, passed = begin(show, now), 0.0
    for jump, elapsed_s in jumps:
        local = now.local + timedelta(seconds=jump + elapsed_s)
        now, passed = ShowClock(local, now.utc_s + jump + elapsed_s), passed + elapsed_s
        progress = advance(show, progress, now, elapsed_s)
        at = passed % 150.0
        expected = (0, at) if at < 100.0 else (1, at - 100.0)
        assert (progress.item, progress.elapsed_s) == pytest.approx(expected, abs=1e-6) or (
            min(at % 50.0, 50.0 - at % 50.0) < 1e-6
        )


@given(st.lists(st.tuples(st.floats(-90000, 90000), st.floats(0.01, 60.0)), max_size=40))
def test_any_clock_leaves_a_show_at_one_of_its_items(jumps):
    now = clock(NINE)
    progress = begin(MORNING, now)
    for jump, elapsed_s in jumps:
        before = progress
        moved = jump + elapsed_s
        now = ShowClock(now.local + timedelta(seconds=moved), now.utc_s + moved)
        progress = advance(MORNING, progress, now, elapsed_s)
        assert 0 <= progress.item < len(MORNING.item) and progress.elapsed_s >= 0.0
        if jump < -5.0:  # set back: the item goes on, or the next follows it
            assert progress.item in (before.item, before.item + 1, before.item + 2)
        assert progress.seen <= max(before.seen, now.local)


def test_a_clock_set_forward_starts_what_it_passed_and_set_back_starts_it_again():
    now = clock(NINE)
    progress = advance(MORNING, begin(MORNING, now), clock(NINE + timedelta(hours=2)), 1.0)
    assert (progress.item, progress.elapsed_s) == (4, 1200.0)  # 10:30, then 600 s
    back = advance(MORNING, progress, clock(NINE + timedelta(minutes=80)), 1.0)
    assert back.item == 4  # nothing starts at once
    _, later = play(MORNING, clock(NINE + timedelta(minutes=80)), back, 601)
    assert later.item == 3


def test_daylight_saving_starts_an_item_once():
    show = Show(item=[ShowItem(scenario="a"), ShowItem(scenario="b", start="02:30", for_s=60.0),
                      ShowItem(scenario="c")])  # fmt: skip
    two = datetime(2026, 10, 25, 2, 0)
    now = ShowClock(two, 0.0)
    now, progress = play(show, now, begin(show, now), 3599, 1.0)
    assert progress.item == 2
    now = ShowClock(two, now.utc_s + 1.0)  # autumn: three o'clock is two again
    progress = advance(show, progress, now, 1.0)
    _, progress = play(show, now, progress, 3599)
    assert progress.item == 2
    now = ShowClock(datetime(2026, 3, 29, 1, 59, 59), 0.0)  # spring: half past two is left out
    progress = advance(show, begin(show, now), ShowClock(datetime(2026, 3, 29, 3, 0), 1.0), 1.0)
    assert progress.item == 2 and progress.elapsed_s == 1740.0  # half an hour of local time


def test_after_a_power_cut_it_goes_on_at_the_second():
    now = clock(NINE)
    _, progress = play(MORNING, now, begin(MORNING, now), 75)
    found = resume(MORNING, progress, clock(NINE + timedelta(minutes=20)))
    assert (found.item, found.elapsed_s) == (1, 15.0)
    assert resume(MORNING, progress, clock(NINE - timedelta(minutes=20))).item == 1  # lost its time
    by_clock = resume(MORNING, progress, clock(NINE + timedelta(minutes=95)))
    assert (by_clock.item, by_clock.elapsed_s) == (3, 300.0)
    assert resume(MORNING, progress, clock(NINE + timedelta(days=1))).item == 0


def test_the_timetable_knows_what_the_clock_tells():
    assert [text for text, _ in timetable(MORNING, NINE.date())] == [
        "first", "after item 1", "on cue", "10:30", "10:40",
    ]  # fmt: skip


class Running:
    """A player with a clock that the test sets."""

    def __init__(self, show, local=NINE, saved=None):
        self.told, self.now = [], clock(local)
        self.player = ShowPlayer(show, self.told.append, saved, lambda: self.now)

    def go(self, seconds, step_s=0.1, jump_s=0.0):
        for _ in range(round(seconds / step_s)):
            moved = step_s + jump_s
            self.now = ShowClock(self.now.local + timedelta(seconds=moved), self.now.utc_s + moved)
            jump_s = 0.0
            self.player.update(step_s)
            if (due := self.player.due) is not None:
                self.player.show_item(due)


def test_screens_are_dark_between_items_and_outside_the_hours():
    show = Show(
        fade_s=1.0,
        hours=OpeningHours(monday="09:00-09:02"),
        item=[
            ShowItem(scenario="a", caption="hello", for_s=10.0),
            ShowItem(scenario="b", fade_s=0.0),
        ],
    )
    running = Running(show)
    player = running.player
    assert player.shade == 1.0 and not player.closed
    running.go(0.6)
    assert player.shown == 0 and 0.0 < player.shade < 1.0
    running.go(1.2)
    assert player.shade == 0.0 and player.caption() == ("hello", 1.0)
    running.go(8.6)
    assert (player.shown, player.shade) == (1, 0.0)  # without a fade
    player.next_cue()
    running.go(0.5)
    assert player.progress.item == 0 and player.shown == 1 and 0.0 < player.shade < 1.0
    running.go(2.0)
    assert (player.shown, player.shade) == (0, 0.0)
    running.go(120.0)
    assert player.closed and not player.state()["open"]
    assert [line for line in running.told if "closes" in line]
    player.next_cue()
    running.go(1.0)
    assert player.closed
    running.now = clock(NINE + timedelta(days=7))
    running.go(1.5)
    assert player.open and player.shown == 0 and player.state()["item"] == 1
    assert player.state()["next"].endswith(" s")


def test_a_jump_of_the_clock_is_one_line():
    running = Running(MORNING)
    running.now = clock(NINE + timedelta(minutes=1))  # loading took a minute
    running.go(5.0)
    assert not running.told
    running.go(1.0, jump_s=-7200.0)
    running.go(5.0)
    assert running.told == ["the clock went back by 7200 s; the show goes on"]
    assert running.player.progress.item == 0


def test_a_night_belongs_to_the_evening_before():
    night = Show(
        hours=OpeningHours(monday="18:00-02:00", tuesday="18:00-02:00"),
        item=[
            ShowItem(scenario="a", for_s=60.0),
            ShowItem(scenario="b", start="23:00"),
        ],
    )
    for time, item in (("2026-11-23 23:30", 1), ("2026-11-24 00:30", 1), ("2026-11-24 17:00", 0)):
        assert begin(night, clock(datetime.fromisoformat(time))).item == item
    on = begin(night, clock(datetime.fromisoformat("2026-11-23 23:50")))
    assert resume(night, on, clock(datetime.fromisoformat("2026-11-24 00:10"))).item == 1
    assert resume(night, on, clock(datetime.fromisoformat("2026-11-24 10:00"))).item == 0


def test_a_caption_that_is_over_leaves_the_console():
    show = Show(fade_s=0.0, item=[ShowItem(scenario="a", caption="Look", caption_s=2.0)])
    player = ShowPlayer(show, lambda line: None, clock=lambda: clock(NINE, 0.0))
    player.show_item(0)
    said = []
    for _ in range(15):
        player.update(0.2)
        said.append(player.caption().words)
    assert said[:9] == ["Look"] * 9 and set(said[11:]) == {""}


def test_screens_that_are_held_stay_black():
    show = Show(item=[ShowItem(scenario="a", caption="Look", caption_s=2.0)])
    player = ShowPlayer(show, lambda line: None, clock=lambda: clock(NINE, 0.0))
    player.show_item(0)
    for _ in range(40):
        player.update(0.2, held=True)
    assert player.shade == 1.0 and player.caption().opacity == 0.0
    for _ in range(6):
        player.update(0.2)
    assert player.shade == 0.0 and player.caption() == ("Look", 1.0)


WEEK = Show(
    special_day=[SpecialDay(title="Carnival", yearly="11-25")],
    item=[
        ShowItem(scenario="a", days=["monday", "tuesday"], for_s=60.0),
        ShowItem(scenario="b", for_s=60.0),
        ShowItem(scenario="c", days=["Carnival"], start="10:30", for_s=60.0),
        ShowItem(scenario="d", days=["saturday"], start="10:30"),
    ],
)


@pytest.mark.parametrize(
    ("day", "items", "table"),
    [
        (23, [0, 1, 0, 1], ["first", "after item 1"]),  # a Monday
        (25, [1, 1, 1, 1], ["first", "10:30"]),  # a Wednesday
        (28, [1, 1, 1, 1], ["first", "10:30"]),  # a Saturday
    ],
)
def test_items_are_on_at_their_days(day, items, table):
    now = clock(datetime(2026, 11, day, 9, 0))
    progress, seen = begin(WEEK, now), []
    for _ in range(4):
        seen.append(progress.item)
        now, progress = play(WEEK, now, progress, 60)
    assert seen == items
    assert [text for text, _ in timetable(WEEK, now.local.date())] == table
    at_ten = begin(WEEK, clock(datetime(2026, 11, day, 10, 30, 5)))
    assert at_ten.item == {23: 0, 25: 2, 28: 3}[day]


def test_an_item_ends_with_its_day():
    show = Show(item=[ShowItem(scenario="a", days=["monday"]), ShowItem(scenario="b", start="cue")])
    now = clock(datetime(2026, 11, 23, 23, 59, 30))
    progress = begin(show, now)
    now, progress = play(show, now, progress, 29)
    assert progress.item == 0
    _, progress = play(show, now, progress, 2)
    assert progress.item == 1


CHASED = Show(
    fade_s=0.0,
    timecode=TimecodeIn(source="ltc"),
    item=[
        ShowItem(scenario="a"),
        ShowItem(scenario="b", start="01:00:00:00", for_s=30.0),
        ShowItem(scenario="c", for_s=10.0),
        ShowItem(scenario="d", start="01:02:00:00"),
    ],
)


def test_a_timecode_says_which_item_is_on():
    places = {0.0: None, 3599.9: None, 3600.0: (1, 0.0), 3615.0: (1, 15.0), 3635.0: (2, 5.0),
              3700.0: (2, 70.0), 3721.0: (3, 1.0), 9000.0: (3, 5280.0)}  # fmt: skip
    for time_s, place in places.items():
        assert place_at(CHASED, time_s, NINE.date()) == place


def test_a_timecode_starts_items_and_a_cue_holds_until_the_next():
    running = Running(CHASED)
    player = running.player

    def heard(time_s, jumps=1):
        player.follow(time_s, jumps)
        running.go(0.1)
        return player.progress.item

    assert heard(None, 0) == 0 and heard(100.0) == 0
    assert heard(3600.0) == 1
    player.next_cue()
    assert heard(3601.0) == 2 and heard(3610.0) == 2  # the presenter is ahead
    assert heard(3631.0) == 2 and player.progress.elapsed_s == pytest.approx(1.0, abs=0.2)
    assert heard(3720.0) == 3
    assert heard(3601.0, 2) == 1  # it has jumped back
    player.go_to(3)
    running.go(0.1)
    assert heard(3602.0, 2) == 3 and heard(3602.0, 3) == 1  # the same item, after a jump
    assert heard(None, 3) == 1
    running.go(40.0)  # it has stopped: the show goes on alone
    assert player.progress.item == 2


def test_captions_of_several_languages_follow_each_other():
    words = {"de": "Guten Tag", "en": "Good day"}
    show = Show(
        fade_s=0.0, languages=["de", "en"],
        item=[ShowItem(scenario="a", caption=words, caption_s=2.0)],
    )  # fmt: skip
    player = ShowPlayer(show, lambda line: None, clock=lambda: clock(NINE, 0.0))
    player.show_item(0)
    said = []
    for _ in range(25):
        player.update(0.2)
        said.append(player.caption().words)
    assert said[:9] == ["Guten Tag"] * 9 and said[11:19] == ["Good day"] * 8
    assert set(said[21:]) == {""}
    item = ShowItem(scenario="a", caption=words)
    assert item.caption_in("de") == "Guten Tag" and item.caption_in("ja") == "Good day"
