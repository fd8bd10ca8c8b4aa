"""Ctrl-C at a moment of our choosing."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def deferred() -> Iterator[Callable[[], None]]:
    """Within, Ctrl-C and a polite kill are noted; the yielded function raises them.

    Raised at once, as Python does, KeyboardInterrupt may come up inside a destructor or a weak
    reference's callback, as the HDF5 library's wrapper has many. There it is printed and lost,
    and the program runs on. The function raises KeyboardInterrupt between two steps instead.
    """
    noted = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal noted
        noted = True

    def check() -> None:
        nonlocal noted
        if noted:
            noted = False
            raise KeyboardInterrupt

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield check
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
