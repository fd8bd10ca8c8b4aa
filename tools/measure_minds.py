"""Time perception and behavior of `open-ocean` with more and more fishes, on one core.

Figures are processor times of the thread.

.venv/bin/python tools/measure_minds.py [FISHES ...]
"""

import sys
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.kernels.threads import use_threads
from subsea.scenario.load import load_scenario
from subsea.state import Clock, Fishes, Minds, Sea
from subsea.submarine.vessel import NEUTRAL
from subsea.world import step
from subsea.world.build import create_world

NUMBERS = (60, 1000, 3000, 10_000, 30_000, 50_000)
STAGES = ("perception", "behavior")
SETTLED, TICKS = 32, 24  # ticks before the first that counts, and those that count


def everybody(
    fishes: Fishes, minds: Minds, sea: Sea, visibility: float, clock: Clock
) -> NDArray[np.integer[Any]]:
    """Let all living fishes think in every tick instead of taking turns."""
    minds.pause[:] += clock.dt
    return np.flatnonzero(fishes.alive)


def medians_ms(number: int) -> list[float]:
    """Median milliseconds of the stages of a tick with this number of fishes."""
    world = create_world(load_scenario("open-ocean")[0], fish=number)
    rows = []
    for tick in range(SETTLED + TICKS):
        step.step(world, NEUTRAL)
        if tick >= SETTLED:
            rows.append([1000.0 * world.stages_s[stage] for stage in STAGES])
    return [float(value) for value in np.median(rows, axis=0)]


def main() -> None:
    """Print a row for each number of fishes: in turns, then all in every tick."""
    numbers = [int(word) for word in sys.argv[1:]] or list(NUMBERS)
    use_threads(1)
    taking_turns = step.fish_due
    step.time = SimpleNamespace(perf_counter=time.thread_time)
    medians_ms(60)  # compiles
    print(f"{'':8s}{'taking turns, ms':>30s}{'everybody, ms':>30s}")
    print(f"{'fishes':8s}" + 2 * f"{'perception':>12s}{'behavior':>10s}{'both':>8s}")
    for number in numbers:
        cells = ""
        for turns in (taking_turns, everybody):
            step.fish_due = turns
            perception, behavior = medians_ms(number)
            cells += f"{perception:12.2f}{behavior:10.2f}{perception + behavior:8.2f}"
        print(f"{number:<8d}{cells}", flush=True)


if __name__ == "__main__":
    main()
