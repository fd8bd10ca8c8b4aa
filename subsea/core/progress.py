"""How far a long work is, and how long it will take still."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

from subsea.core.console import say

TELL_S = 10.0  # between two lines where there is no terminal


@contextmanager
def progress(total: int, unit: str, done: int = 0) -> Iterator[Callable[[], object]]:
    """A function to call once for each of `total` units, of which `done` are done already.

    A bar on a terminal. Elsewhere, where a bar would fill a log, a line now and then.
    """
    if sys.stderr.isatty():
        with tqdm(total=total, initial=done, unit=unit) as bar:
            yield bar.update
        return
    told, told_s = done, time.monotonic()

    def count() -> None:
        nonlocal done, told, told_s
        done += 1
        now = time.monotonic()
        if now - told_s >= TELL_S:
            rate = (done - told) / (now - told_s)
            left = clock((total - done) / rate)
            say(f"{unit} {done} of {total}, {rate:.2g} a second, {left} left")
            told, told_s = done, now

    yield count


def clock(seconds: float) -> str:
    """Such as 0:07 or 1:02:03."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
