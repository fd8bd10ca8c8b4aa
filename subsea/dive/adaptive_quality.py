"""Adaptive quality: hold a target frame time.

A `Pace` is a rung of `render.output.quality.LADDER` and what is known of its cost. It steps down
when frames take too long, and up when the next rung is expected to be quick enough; hysteresis
between the two lets it settle.
"""

from itertools import pairwise
from statistics import median
from typing import NamedTuple, TypeVar

from subsea.rendering.output.quality import LADDER, PRESETS, on_software

GPU_TARGET_MS = 1000.0 / 60.0
SOFTWARE_TARGET_MS = 1000.0 / 20.0  # smooth enough to steer; a finer picture is worth more
SETTLING = 3  # frames after a change that do not count: shaders compile
BRIEF, LONG = 24, 90  # frames whose median decides on a step down, and up
TOO_SLOW, QUICK = 1.08, 0.85  # of the target: step down above, up if expected below
PATIENT = 300  # frames to wait before the step to another preset, which is visible
MOST_PATIENT = 2400  # limit of the waiting time, which doubles after each failed step
PRESET_RATIO = 1.8  # assumed cost of the next preset, until it was measured


T = TypeVar("T")


class Pace(NamedTuple):
    """The state of the controller; `start` makes the first, `paced` each further one."""

    rung: int  # on the LADDER
    since: int  # frames since the last change
    times: tuple[float, ...]  # of those that count, ms, at most LONG, the newest last
    ratios: tuple[float, ...]  # time of a frame at rung k + 1 over that at rung k
    patience: tuple[int, ...]  # frames at rung k before k + 1 is tried
    rose_from_ms: float  # median frame at the rung below if the last step led up, else 0
    lowest: int = 0  # the rung below which it does not go


def start(rung: int, exact: bool = False) -> Pace:
    """Begin on a rung of the LADDER, without measurements.

    A rig with an `exact` canvas does not use the rungs with smaller ones.
    """
    ratios, patience = [], []
    for a, b in pairwise(LADDER):
        finer = a.scale != b.scale
        ratios.append((b.scale / a.scale) ** 2 if finer else PRESET_RATIO)
        patience.append(LONG if finer else PATIENT)
    lowest = LADDER.index(PRESETS["low"]) if exact else 0
    return Pace(rung, 0, (), tuple(ratios), tuple(patience), 0.0, lowest)


def paced(pace: Pace, frame_ms: float, target_ms: float) -> Pace:
    """The pace after a frame of `frame_ms`; moves by at most one rung.

    Medians ignore single long frames. A rung that was too slow is tried again only when its
    measured cost fits.
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
    if len(pace.times) == LONG:  # the step up has succeeded
        pace = pace._replace(rose_from_ms=0.0)
    if len(pace.times) == LONG and rung < len(pace.ratios) and pace.since >= pace.patience[rung]:
        lasting = median(pace.times)
        if pace.ratios[rung] * lasting < QUICK * target_ms:
            return pace._replace(rung=rung + 1, since=0, times=(), rose_from_ms=lasting)
    return pace


def resumed(pace: Pace) -> Pace:
    """Continue after other frames, which do not count."""
    return pace._replace(since=0, times=(), rose_from_ms=0.0)


def target_for(renderer: str) -> float:
    """The default target in ms, by the name of the renderer."""
    return SOFTWARE_TARGET_MS if on_software(renderer) else GPU_TARGET_MS


def _ratio(pace: Pace, frame_ms: float) -> float:
    """The measured cost of the step up, at least a little more than 1."""
    return max(frame_ms / pace.rose_from_ms, 1.02)


def _with(values: tuple[T, ...], place: int, value: T) -> tuple[T, ...]:
    return (*values[:place], value, *values[place + 1 :])
