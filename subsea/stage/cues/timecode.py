"""Follow a timecode, or ignore it, by one rule.

A time is believed when it has gone on with the clock for LOCK_S. From then on labels are expected
as the clock goes on: one that differs is ignored, until others have gone on from it for LOCK_S,
which is a jump. Without labels for LOST_S the timecode has stopped, and the show goes on alone. So
a label that is misread, a tape that is wound and one that stands still change nothing.
"""

import re
from typing import Literal, NamedTuple

Rate = Literal["24", "25", "29.97", "30"]  # frames a second; 29.97 drops labels
RATES: dict[Rate, float] = {"24": 24.0, "25": 25.0, "29.97": 30000.0 / 1001.0, "30": 30.0}

LOCK_S = 0.5  # for which labels must go on with the clock
LOST_S = 0.5  # without a label: it has stopped
STRAY_S = 0.2  # of labels that differ from those that go on, before they may be a jump
NEAR_S = 0.12  # from where the clock says that a label is due: three frames
DRIFT = 0.02  # share of such a difference that is made up for: sources may be off by some percent
DAY_S = 86400.0
_LABEL = re.compile(r"(\d\d):([0-5]\d):([0-5]\d)[:;.](\d\d)")


class FrameLabel(NamedTuple):
    """A label of a frame."""

    hours: int
    minutes: int
    seconds: int
    frames: int

    def __str__(self) -> str:
        """The usual form, such as 01:00:00:00."""
        return ":".join(f"{part:02d}" for part in self)


def parsed_label(text: str) -> FrameLabel:
    """Read a label such as ``01:00:00:00``; a ValueError for anything else."""
    found = _LABEL.fullmatch(text.strip())
    label = FrameLabel(*map(int, found.groups())) if found else FrameLabel(24, 0, 0, 0)
    if label.hours > 23 or label.frames > 29:
        raise ValueError(f"{text!r}: expected a timecode such as 01:00:00:00")
    return label


def seconds_of(label: FrameLabel, rate: Rate) -> float:
    """Compute the seconds from 00:00:00:00 to a label.

    Of 29.97 frames a second, labels 0 and 1 of each minute are left out but of each tenth one, so
    that labels go with the clock.
    """
    whole = round(RATES[rate])
    minutes = 60 * label.hours + label.minutes
    frames = whole * (60 * minutes + label.seconds) + label.frames
    if rate == "29.97":
        frames -= 2 * (minutes - minutes // 10)
    return frames / RATES[rate]


class _Run(NamedTuple):
    """Labels that go on with the clock."""

    since_s: float  # when the first one came, by the clock ...
    heard_s: float  # ... and the last one
    ahead_s: float  # of the clock

    def off(self, time_s: float, now_s: float) -> float:
        """Compute by how much a time is ahead of the one that is due, within half a day."""
        return (time_s - now_s - self.ahead_s + DAY_S / 2) % DAY_S - DAY_S / 2

    def goes_on(self, time_s: float, now_s: float) -> bool:
        """True if a label comes when the clock expects it."""
        return abs(self.off(time_s, now_s)) <= NEAR_S

    def after(self, time_s: float, now_s: float) -> "_Run":
        """The run with one more label; it drifts with a source that is a little fast or slow."""
        drift_s = DRIFT * self.off(time_s, now_s)
        return _Run(self.since_s, now_s, self.ahead_s + drift_s)


class TimecodeFollower:
    """Decides which time a timecode shows. Times are seconds; `now_s` is of a steady clock."""

    def __init__(self) -> None:
        """Start without a timecode."""
        self._run: _Run | None = None  # that is followed
        self._other: _Run | None = None  # that may be a jump
        self.jumps = 0  # so far, the first lock among them

    def hear(self, time_s: float, now_s: float) -> None:
        """Take the time of a label."""
        if self._run is not None and self._run.goes_on(time_s, now_s):
            self._run, self._other = self._run.after(time_s, now_s), None
            return
        other = self._other
        if other is None or not other.goes_on(time_s, now_s):
            if other is None or now_s - other.heard_s > STRAY_S:
                self._other = _Run(now_s, now_s, time_s - now_s)
            return  # else one that was misread, while others go on
        self._other = other.after(time_s, now_s)
        if now_s - other.since_s >= LOCK_S:
            self._run, self._other = self._other, None
            self.jumps += 1

    def time_at(self, now_s: float) -> float | None:
        """The time that is followed; None if the timecode has stopped, or was never believed."""
        if self._run is None or now_s - self._run.heard_s > LOST_S:
            return None
        return (now_s + self._run.ahead_s) % DAY_S
