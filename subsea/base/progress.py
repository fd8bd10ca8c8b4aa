"""Progress and remaining time of long work.

Messages on the terminal.

Statistics of frame times.
"""

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from subsea.base.errors import printable


def say(message: str) -> None:
    """Print a message to standard error, as one line; file names may have line breaks."""
    print(f"subsea: {printable(message)}", file=sys.stderr, flush=True)


def count_noun(number: int, one: str, many: str) -> str:
    """A number with its noun: 1 fish, 1,200 fishes."""
    return f"{number:,} {one if number == 1 else many}"


REPORT_S = 10.0  # between two lines without a terminal


@contextmanager
def progress(total: int, unit: str, done: int = 0) -> Iterator[Callable[[], object]]:
    """Yield a function to call after each of `total` units; `done` units are already done.

    Shows a bar on a terminal; elsewhere a line every `REPORT_S`, to keep logs short.
    """
    if sys.stderr.isatty():
        with tqdm(total=total, initial=done, unit=unit) as bar:
            yield bar.update
        return
    reported, reported_s = done, time.monotonic()

    def count() -> None:
        nonlocal done, reported, reported_s
        done += 1
        now = time.monotonic()
        if now - reported_s >= REPORT_S:
            rate = (done - reported) / (now - reported_s)
            left = clock((total - done) / rate)
            say(f"{unit} {done} of {total}, {rate:.2g} a second, {left} left")
            reported, reported_s = done, now

    yield count


def clock(seconds: float) -> str:
    """Format a duration as 0:07 or 1:02:03."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"


SUMMARY = ("mean", "p50", "p95", "p99", "max")


def summarize_ms(durations_s: Sequence[float] | NDArray[np.floating[Any]]) -> dict[str, float]:
    """Mean, percentiles and maximum in milliseconds of durations in seconds, keyed by SUMMARY.

    Percentiles are interpolated linearly.
    """
    ms = 1000.0 * np.asarray(durations_s, np.float64)
    p50, p95, p99 = np.percentile(ms, [50, 95, 99])
    return dict(zip(SUMMARY, map(float, (ms.mean(), p50, p95, p99, ms.max())), strict=True))


def describe_durations(durations_s: Sequence[float]) -> str:
    """Number of frames and statistics of their times, in one line."""
    figures = summarize_ms(durations_s)
    named = ", ".join(f"{name} {figures[name]:.1f}" for name in ("mean", "p50", "p95", "max"))
    return f"{count_noun(len(durations_s), 'frame', 'frames')}; frame time in ms: {named}"
