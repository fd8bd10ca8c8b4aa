"""The time that a timecode shows: in order, misread, wound, standing still, stopped, jumping."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.cues.timecode import (
    LOCK_S,
    RATES,
    FrameLabel,
    TimecodeFollower,
    parsed_label,
    seconds_of,
)

FRAME_S = 0.04


def play(follower, time_s, now_s, seconds, speed=1.0):
    """Hear labels for some seconds; returns the times of timecode and clock after them."""
    for _ in range(round(seconds / FRAME_S)):
        now_s, time_s = now_s + FRAME_S, time_s + speed * FRAME_S
        follower.hear(time_s, now_s)
    return time_s, now_s


@pytest.fixture
def running():
    """A follower that has heard ten seconds from an hour on, and both times."""
    follower = TimecodeFollower()
    return follower, *play(follower, 3600.0, 100.0, 10.0)


def test_labels_are_seconds_of_the_clock():
    assert seconds_of(FrameLabel(1, 0, 0, 12), "24") == 3600.5
    assert seconds_of(FrameLabel(0, 0, 10, 5), "25") == pytest.approx(10.2)
    assert str(parsed_label("01:02:03:04")) == "01:02:03:04"
    assert parsed_label("01:02:03;04") == (1, 2, 3, 4)
    for wrong in ("1:2:3:4", "24:00:00:00", "01:60:00:00", "01:00:00:30", "10:30", "aa:bb:cc:dd"):
        with pytest.raises(ValueError, match="such as 01:00:00:00"):
            parsed_label(wrong)


def test_dropped_labels_keep_to_the_clock():
    """SMPTE ST 12-1: a day of 29.97 has 2,589,408 frames, 86.4 ms short of the clock's day."""
    last = FrameLabel(23, 59, 59, 29)
    assert seconds_of(last, "29.97") * RATES["29.97"] == pytest.approx(2_589_407)
    assert abs(seconds_of(last, "29.97") + 1 / RATES["29.97"] - 86400.0) == pytest.approx(
        0.0864, abs=1e-4
    )
    after = seconds_of(FrameLabel(0, 1, 0, 2), "29.97") - seconds_of(
        FrameLabel(0, 0, 59, 29), "29.97"
    )
    assert after == pytest.approx(1.0 / RATES["29.97"])
    ten = seconds_of(FrameLabel(0, 10, 0, 0), "29.97") - seconds_of(
        FrameLabel(0, 9, 59, 29), "29.97"
    )
    assert ten == pytest.approx(1.0 / RATES["29.97"])


def test_a_timecode_is_believed_after_half_a_second_and_goes_on_between_labels():
    follower = TimecodeFollower()
    time_s, now_s = play(follower, 3600.0, 0.0, LOCK_S)
    assert follower.time_at(now_s) is None
    time_s, now_s = play(follower, time_s, now_s, 2 * FRAME_S)
    assert follower.time_at(now_s) == pytest.approx(time_s)
    assert follower.time_at(now_s + 0.3) == pytest.approx(time_s + 0.3)
    assert follower.jumps == 1


def test_a_noisy_timecode_is_believed_as_soon_as_a_clean_one():
    follower, random = TimecodeFollower(), np.random.default_rng(3)
    for k in range(1, 18):
        time_s = random.uniform(0.0, 86399.0) if k % 4 == 0 else 3600.0 + k * FRAME_S
        follower.hear(time_s, k * FRAME_S)
    assert follower.time_at(17 * FRAME_S) == pytest.approx(3600.0 + 17 * FRAME_S, abs=0.01)
    noise = TimecodeFollower()
    for k in range(200):
        noise.hear(random.uniform(0.0, 86399.0), k * FRAME_S)
    assert noise.time_at(200 * FRAME_S) is None


def test_a_label_that_is_misread_changes_nothing(running):
    follower, time_s, now_s = running
    for wrong in (0.0, 7000.0, 80000.0):
        follower.hear(wrong, now_s + 0.01)
        assert follower.time_at(now_s + 0.01) == pytest.approx(time_s + 0.01)
    time_s, now_s = play(follower, time_s, now_s, 1.0)
    assert follower.time_at(now_s) == pytest.approx(time_s) and follower.jumps == 1


def test_a_jump_is_followed_when_it_has_held(running):
    follower, time_s, now_s = running
    _, now_s = play(follower, 60.0, now_s, 0.4)
    assert follower.time_at(now_s) == pytest.approx(time_s + 0.4)  # it still goes on alone
    time_s, now_s = play(follower, 60.4, now_s, 0.2)
    assert follower.time_at(now_s) == pytest.approx(time_s) and follower.jumps == 2


def test_a_timecode_that_stops_leaves_the_show_alone_and_is_known_when_it_comes_back(running):
    follower, time_s, now_s = running
    assert follower.time_at(now_s + 0.49) is not None
    assert follower.time_at(now_s + 0.51) is None
    follower.hear(time_s + 20.0, now_s + 20.0)  # it only could not be heard
    assert follower.time_at(now_s + 20.0) == pytest.approx(time_s + 20.0)
    assert follower.jumps == 1


@pytest.mark.parametrize("speed", [0.0, 0.5, -1.0, 3.0, 10.0])
def test_a_tape_that_stands_or_is_wound_is_not_followed(running, speed):
    follower, time_s, now_s = running
    _, now_s = play(follower, time_s, now_s, 5.0, speed)
    assert follower.time_at(now_s) is None and follower.jumps == 1


@pytest.mark.parametrize("speed", [0.98, 1.02])
def test_a_source_that_is_a_little_off_is_followed(running, speed):
    follower, time_s, now_s = running
    time_s, now_s = play(follower, time_s, now_s, 60.0, speed)
    assert follower.time_at(now_s) == pytest.approx(time_s, abs=0.06) and follower.jumps == 1


def test_midnight_is_no_jump():
    follower = TimecodeFollower()
    _, now_s = play(follower, 86398.0, 0.0, 1.0)
    for k in range(50):
        follower.hear((86399.0 + k * FRAME_S) % 86400.0, now_s + k * FRAME_S)
    assert follower.jumps == 1 and follower.time_at(now_s + 49 * FRAME_S) == pytest.approx(0.96)


@given(st.lists(st.tuples(st.floats(0, 86399), st.floats(0, 2)), max_size=50))
def test_any_labels_give_a_time_of_a_day_or_none(labels):
    follower, now_s = TimecodeFollower(), 0.0
    for time_s, passed_s in labels:
        now_s += passed_s
        follower.hear(time_s, now_s)
        shown = follower.time_at(now_s)
        assert shown is None or 0.0 <= shown < 86400.0
