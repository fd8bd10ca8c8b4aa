"""Messages on the terminal; progress and remaining time of long work."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from subsea.base.errors import printable


def say(message: str) -> None:
    """Print a message to standard error, as one line; file names may have line breaks."""
    print(f"subsea: {printable(message)}", file=sys.stderr, flush=True)


def print_line(text: object) -> None:
    """Print a line of results; titles and names in files may have line breaks and escapes."""
    print(printable(str(text)))


def count_noun(number: int, one: str, many: str) -> str:
    """A number with its noun: 1 fish, 1,200 fishes."""
    return f"{number:,} {one if number == 1 else many}"


REPORT_S = 10.0  # between two lines without a terminal


@contextmanager
def progress(total: int, unit: str, done: int = 0) -> Iterator[Callable[..., object]]:
    """Yield a function to call after each of `total` units; `done` units are already done.

    The function takes the number of units, if these are several at once.

    Shows a bar on a terminal; elsewhere a line every `REPORT_S`, to keep logs short.
    """
    if sys.stderr.isatty():
        from tqdm import tqdm  # takes a while to load

        with tqdm(total=total, initial=done, unit=unit) as bar:
            yield bar.update
        return
    reported, reported_s = done, time.monotonic()

    def count(number: int = 1) -> None:
        nonlocal done, reported, reported_s
        done += number
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
