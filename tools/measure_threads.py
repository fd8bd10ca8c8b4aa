"""Time a tick of `open-ocean` on one and more threads, and estimate it for more cores.

.venv/bin/python tools/measure_threads.py [FISHES ...] [--threads 1,2] [--cores 16] [--ticks N]

Ticks are measured by the clock, in turn, so the computer must be idle. The estimate runs the parts
of each pass one after another, as cut for that number of cores, and shares out their processor
times as threads would, each taking the next part when it is done. Memory that cores share, and the
interpreter's lock, are not in it; the share of the tick outside of parts is.
"""

import argparse
import heapq
import time
from collections.abc import Sequence

import numpy as np

from subsea.kernels import threads
from subsea.kernels.threads import use_threads
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import World

SETTLED = 16  # ticks before the first that counts


def by_clock_ms(world: World, numbers: Sequence[int], ticks: int) -> dict[int, list[float]]:
    """Milliseconds of ticks on each number of threads, in turn."""
    found: dict[int, list[float]] = {number: [] for number in numbers}
    for _ in range(ticks):
        for number in numbers:
            use_threads(number)
            step(world, NEUTRAL)  # starts the threads
            begin = time.perf_counter()
            step(world, NEUTRAL)
            found[number].append(1000.0 * (time.perf_counter() - begin))
    use_threads()
    return found


def estimate_ms(world: World, cores: int, ticks: int) -> tuple[float, float, float]:
    """Medians of a tick on one core, of what is outside of its parts, and on `cores`, ms."""
    rows: list[tuple[float, float, float]] = []
    passes: list[list[float]] = []

    def run_in_turn(crew: object, tasks: Sequence[threads.Task]) -> None:
        spent = []
        for task in tasks:
            begin = time.thread_time()
            task()
            spent.append(1000.0 * (time.thread_time() - begin))
        passes.append(spent)

    run = threads._Pool.run
    use_threads(cores)
    threads._Pool.run = run_in_turn  # type: ignore[method-assign]
    try:
        for _ in range(ticks):
            passes.clear()
            begin = time.thread_time()
            step(world, NEUTRAL)
            whole = 1000.0 * (time.thread_time() - begin)
            shared = [spent for spent in passes if len(spent) > 1]
            outside = whole - sum(map(sum, shared))
            rows.append((whole, outside, outside + sum(_makespan(one, cores) for one in shared)))
    finally:
        threads._Pool.run = run  # type: ignore[method-assign]
        use_threads()
    whole, outside, together = np.median(rows, axis=0)
    return float(whole), float(outside), float(together)


def _makespan(spent: list[float], cores: int) -> float:
    """Time until all tasks are done, if each core takes the next when it is free."""
    free = [0.0] * cores
    for one in spent:
        heapq.heapreplace(free, free[0] + one)
    return max(free)


def main() -> None:
    """Print a row for each number of fishes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fishes", nargs="*", type=int, default=[30_000, 100_000])
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--cores", type=int, default=16)
    parser.add_argument("--ticks", type=int, default=24)
    options = parser.parse_args()
    numbers = [int(word) for word in options.threads.split(",")]
    for fishes in options.fishes:
        world = create_world(load_scenario("open-ocean")[0], fish=fishes)
        use_threads(1)
        for _ in range(SETTLED):
            step(world, NEUTRAL)
        found = by_clock_ms(world, numbers, options.ticks)
        print(f"{fishes} fishes, ms a tick")
        for number, times in found.items():
            least, median = min(times), float(np.median(times))
            gain = min(found[numbers[0]]) / least
            print(f"  {number:3d} threads, by the clock: least {least:.1f}, median {median:.1f};"
                  f" {gain:.2f} times as fast")  # fmt: skip
        for cores in (2, options.cores):
            whole, outside, together = estimate_ms(world, cores, options.ticks)
            print(
                f"  {cores:3d} cores, estimate: {together:.1f} of {whole:.1f}, {outside:.2f} not"
                f" in parts ({outside / whole:.1%}); {whole / together:.1f} times as fast",
                flush=True,
            )


if __name__ == "__main__":
    main()
