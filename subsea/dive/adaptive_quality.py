"""The quality that chooses itself: from one frame to the next, so that a target time is held.

A pace is where on `render.quality.LADDER` the picture stands, and what is known of its cost. It
steps down when frames take too long, and up when the next rung would still be quick enough:
between the two lies a range in which nothing changes, so it comes to rest.
"""

from itertools import pairwise
from statistics import median
from typing import NamedTuple, TypeVar

from subsea.render.output.quality import LADDER, PRESETS, on_software

GPU_TARGET_MS = 1000.0 / 60.0
SOFTWARE_TARGET_MS = 1000.0 / 20.0  # smooth enough to steer; a finer picture is worth more
SETTLING = 3  # frames after a change that tell nothing: shaders compile, buffers are made
BRIEF, LONG = 24, 90  # frames whose median leads down, and up
TOO_SLOW, QUICK = 1.08, 0.85  # of the target: above is too long, and foreseen below is room
PATIENT = 300  # frames to wait before another preset, which one sees come, is taken up
MOST_PATIENT = 2400  # a rung that was too slow before is tried ever more seldom, to this limit
PRESET_RATIO = 1.8  # how much longer a frame of the next preset takes, until it was measured


T = TypeVar("T")


class Pace(NamedTuple):
    """What is known; `start` makes the first, `paced` every further one."""

    rung: int  # on the LADDER
    since: int  # frames since the last change
    times: tuple[float, ...]  # of those that count, ms, at most LONG, the newest last
    ratios: tuple[float, ...]  # time of a frame at rung k + 1 over that at rung k
    patience: tuple[int, ...]  # frames at rung k before k + 1 is tried
    rose_from_ms: float  # median frame at the rung below if the last step led up, else 0
    lowest: int = 0  # the rung below which it does not go


def start(rung: int, exact: bool = False) -> Pace:
    """A pace that begins on this rung of the LADDER and knows nothing yet.

    A rig whose canvas is `exact` has no use for the rungs of smaller ones.
    """
    ratios, patience = [], []
    for a, b in pairwise(LADDER):
        finer = a.scale != b.scale
        ratios.append((b.scale / a.scale) ** 2 if finer else PRESET_RATIO)
        patience.append(LONG if finer else PATIENT)
    lowest = LADDER.index(PRESETS["low"]) if exact else 0
    return Pace(rung, 0, (), tuple(ratios), tuple(patience), 0.0, lowest)


def paced(pace: Pace, frame_ms: float, target_ms: float) -> Pace:
    """The pace after a frame that took `frame_ms`; at most one rung from where it was.

    A single long frame moves no median. A rung that turned out too slow is not tried again
    before frames have become so much quicker that its measured cost fits.
    """
    pace = pace._replace(since=pace.since + 1)
    if pace.since <= SETTLING:
        return pace
    pace = pace._replace(times=(*pace.times, frame_ms)[-LONG:])
    if len(pace.times) < BRIEF:
        return pace
    brief, rung = median(pace.times[-BRIEF:]), pace.rung
    if len(pace.times) == BRIEF and pace.rose_from_ms:
        pace = pace._replace(ratios=_with(pace.ratios, rung - 1, _ratio(pace, brief)))
    if brief > TOO_SLOW * target_ms and rung > pace.lowest:
        if pace.rose_from_ms:
            longer = min(2 * pace.patience[rung - 1], MOST_PATIENT)
            pace = pace._replace(patience=_with(pace.patience, rung - 1, longer))
        return pace._replace(rung=rung - 1, since=0, times=(), rose_from_ms=0.0)
    if len(pace.times) == LONG:  # it held: what happens later is not for the step up
        pace = pace._replace(rose_from_ms=0.0)
    if len(pace.times) == LONG and rung < len(pace.ratios) and pace.since >= pace.patience[rung]:
        lasting = median(pace.times)
        if pace.ratios[rung] * lasting < QUICK * target_ms:
            return pace._replace(rung=rung + 1, since=0, times=(), rose_from_ms=lasting)
    return pace


def resumed(pace: Pace) -> Pace:
    """The pace when quality chooses itself again: what was drawn meanwhile tells nothing."""
    return pace._replace(since=0, times=(), rose_from_ms=0.0)


def target_for(renderer: str) -> float:
    """The time of a frame in ms to hold where none is asked for, by the name of the renderer."""
    return SOFTWARE_TARGET_MS if on_software(renderer) else GPU_TARGET_MS


def _ratio(pace: Pace, frame_ms: float) -> float:
    """What the step up cost; nothing is cheaper for being finer, whatever the scene did."""
    return max(frame_ms / pace.rose_from_ms, 1.02)


def _with(values: tuple[T, ...], place: int, value: T) -> tuple[T, ...]:
    return (*values[:place], value, *values[place + 1 :])
