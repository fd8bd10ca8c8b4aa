"""Work that takes long, in a thread of its own, while the windows hear what hands do."""

import atexit
import os
import sys
from collections.abc import Callable
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TypeVar

T = TypeVar("T")

LOOK_S = 0.03  # between two looks at the windows


class LeftError(Exception):
    """The visitor left before there was anything to see."""


def meanwhile(work: Callable[[Callable[[str], None]], T], look: Callable[[str | None], None]) -> T:
    """What `work` returns or raises; `look` is called over and over until then, in this thread.

    `work` is given a function to tell how far it is. `look` is given each of these lines once,
    else None, and may raise, `LeftError` for instance: then nobody waits for the work any more.
    """
    lines: SimpleQueue[str] = SimpleQueue()
    results: list[T] = []
    faults: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work(lines.put))
        except BaseException as fault:
            faults.append(fault)

    thread = Thread(target=run, name="loading", daemon=True)
    thread.start()
    try:
        while thread.is_alive() or not lines.empty():
            try:
                look(lines.get(timeout=LOOK_S))
            except Empty:
                look(None)
    except BaseException as reason:
        code = (
            130
            if isinstance(reason, KeyboardInterrupt)
            else 0
            if isinstance(reason, LeftError)
            else 1
        )
        atexit.register(_end, thread, code)
        raise
    if faults:
        raise faults[0]
    return results[0]


def _end(thread: Thread, code: int) -> None:
    """End the process at once if `thread` still works.

    It may be deep in a compiler, which nothing can interrupt, and which would crash when the
    process is taken down around it.
    """
    if thread.is_alive():
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
