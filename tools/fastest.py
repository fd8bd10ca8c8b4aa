"""The shortest of several runs, which other work on the computer disturbs least."""

import time
from collections.abc import Callable


def fastest_ms(
    work: Callable[[], object], clock: Callable[[], float] = time.process_time, repeats: int = 5
) -> float:
    """The least time of ``work`` by a clock, ms; a first run compiles and is not counted."""
    work()
    durations = []
    for _ in range(repeats):
        start = clock()
        work()
        durations.append(clock() - start)
    return 1000.0 * min(durations)
