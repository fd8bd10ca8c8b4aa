"""Defer Ctrl-C to safe points."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Record Ctrl-C and SIGTERM; the yielded function raises KeyboardInterrupt for them.

    Python raises KeyboardInterrupt at once, which may be inside a destructor or a weak
    reference's callback (the HDF5 wrapper has many). There it is printed and lost, and the
    program goes on. Call the yielded function between two steps instead.
    """
    pending = False

    def record(number: int, frame: FrameType | None) -> None:
        nonlocal pending
        pending = True

    def check() -> None:
        nonlocal pending
        if pending:
            pending = False
            raise KeyboardInterrupt

    before = {number: signal.signal(number, record) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield check
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
