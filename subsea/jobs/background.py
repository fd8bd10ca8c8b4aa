"""Run long work in a thread while the windows handle events."""

import atexit
import os
import sys
from collections.abc import Callable
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TypeVar

T = TypeVar("T")

LOOK_S = 0.03  # interval at which the windows handle events


class CancelledByUserError(Exception):
    """The user closed the window while the dive was loading."""


def run_in_background(
    work: Callable[[Callable[[str], None]], T],
    look: Callable[[str | None], None],
    every_s: float = LOOK_S,
) -> T:
    """Return or raise the result of `work`; call `look` in this thread until it is done.

    `work` receives a function to report progress in lines. `look` receives each of these lines
    once, else None every `every_s`. If it raises, as `CancelledByUserError`, the work is abandoned.
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
                look(lines.get(timeout=every_s))
            except Empty:
                look(None)
    except BaseException as reason:
        code = {KeyboardInterrupt: 130, CancelledByUserError: 0}.get(type(reason), 1)
        atexit.register(_end, thread, code)
        raise
    if faults:
        raise faults[0]
    return results[0]


def _end(thread: Thread, code: int) -> None:
    """End the process at once if `thread` still runs.

    It may be inside a compiler, which cannot be interrupted and would crash while the
    interpreter shuts down.
    """
    if thread.is_alive():
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
