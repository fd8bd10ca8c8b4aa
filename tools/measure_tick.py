"""Measure a tick of `open-ocean` with many fishes: its stages, and its share of parallel work.

.venv/bin/python tools/measure_tick.py [--fish N] [--ticks N] [--cores N] [--against FOLDER]

Figures are milliseconds of processor time, medians: perception, behavior and motor system, with
fishes that take turns to think and with all in every tick; then the tick on one core, what of it is
not in parallel parts, and an estimate for more cores. The estimate runs the parts of each pass one
after another, as cut for that number of cores, and shares out their times as threads would, each
taking the next part when it is done. It leaves out the memory and the interpreter's lock that cores
share.
"""

import argparse
import heapq
import time
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from subsea.kernels import threads
from subsea.kernels.threads import use_threads
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world import step
from subsea.world.build import create_world
from subsea.world.world import World
from tools.measuring import Figures, main

STAGES = ("perception", "behavior", "motor")
SETTLED = 32  # ticks before the first that counts


def measured(options: argparse.Namespace) -> Figures:
    """Measure the stages, and estimate the tick on several cores."""
    figures = stages_ms("", options)
    taking_turns, step.fish_due = step.fish_due, everybody
    figures |= stages_ms(", all fishes in every tick", options)
    step.fish_due = taking_turns
    world = settled(options.fish)
    for cores in (2, options.cores):
        whole, outside, together = estimate_ms(world, cores, options.ticks)
        figures |= {"a tick on one core": whole, f"not in parts, {cores} cores": outside}
        figures[f"estimate for {cores} cores"] = together
    return figures


def everybody(fishes: Any, minds: Any, sea: Any, visibility: float, clock: Any) -> Any:
    """Let all living fishes think in every tick instead of taking turns."""
    minds.pause[:] += clock.dt
    return np.flatnonzero(fishes.alive)


def settled(fish: int) -> World:
    """Make a sea in which the fishes have found each other."""
    world = create_world(load_scenario("open-ocean")[0], fish=fish)
    use_threads(1)
    for _ in range(SETTLED):
        step.step(world, NEUTRAL)
    return world


def stages_ms(suffix: str, options: argparse.Namespace) -> dict[str, float]:
    """Measure the stages of a tick on one thread."""
    world, rows = settled(options.fish), []
    wall, step.time = step.time, SimpleNamespace(perf_counter=time.thread_time)
    for _ in range(options.ticks):
        step.step(world, NEUTRAL)
        rows.append([1000.0 * world.stages_s[stage] for stage in STAGES])
    step.time = wall
    medians = np.median(rows, axis=0).tolist()
    return {f"{stage}{suffix}": ms for stage, ms in zip(STAGES, medians, strict=True)}


def estimate_ms(world: World, cores: int, ticks: int) -> tuple[float, float, float]:
    """Estimate a tick on one core, what of it is outside of parts, and on `cores`, ms."""
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
            step.step(world, NEUTRAL)
            whole = 1000.0 * (time.thread_time() - begin)
            shared = [spent for spent in passes if len(spent) > 1]
            outside = whole - sum(map(sum, shared))
            rows.append((whole, outside, outside + sum(makespan(tasks, cores) for tasks in shared)))
    finally:
        threads._Pool.run = run  # type: ignore[method-assign]
        use_threads()
    whole, outside, together = np.median(rows, axis=0)
    return float(whole), float(outside), float(together)


def makespan(spent: list[float], cores: int) -> float:
    """Compute when all tasks are done, if each core takes the next task when it is free."""
    free = [0.0] * cores
    for duration in spent:
        heapq.heapreplace(free, free[0] + duration)
    return max(free)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fish", type=int, default=10_000)
    parser.add_argument("--ticks", type=int, default=24)
    parser.add_argument("--cores", type=int, default=16)
    main(parser, measured, times=1)
