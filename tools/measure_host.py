"""Measure the host's share of a frame: everything but the drawing calls.

LP_NUM_THREADS=1 .venv/bin/python tools/measure_host.py [SCENARIO] [--fish N,…] [--against CHECKOUT]

Figures are processor time of the calling thread, ms a frame, medians: the tick, the views, packing,
and the renderer without its drawing calls; then the drawing calls, and all threads. With --against
another checkout is measured in turn, each four times, and the ratio is of the least of each.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent.parent
WARM_UP = 30
ROUNDS = 4
HOST = ("tick", "views", "pack", "renderer")
ROWS = (*HOST, "host", "drawing calls", "all threads")


def measured(scenario: str, fish: int | None, display: str, frames: int) -> dict[str, float]:
    """Medians of the parts of a frame, ms."""
    from subsea.dive.start import headless, picture_maker, start_world
    from subsea.dive.tour import Tour
    from subsea.frame.packet import pack
    from subsea.rendering.output.quality import PRESETS
    from subsea.view.display_rigs import cockpit, display_rig
    from subsea.view.levels import empty_lod_state
    from subsea.view.rig import views
    from subsea.world.step import step

    quality, rig, tour = PRESETS["low"], display_rig(display, (1280, 720)), Tour()
    rows = []
    with headless() as context:
        world = start_world(scenario, fish=fish, tell=lambda message: None)
        drawing = _count_processor_time(context.extra)
        memory = empty_lod_state(len(world.state.fishes.species))
        with picture_maker(context, world, rig, quality) as renderer:
            for _ in range(WARM_UP + frames):
                order = tour.helm(world)
                context.finish()
                whole, marks = time.process_time(), [time.thread_time()]
                step(world, order)
                marks.append(time.thread_time())
                seen = views(rig, cockpit(world.state.submarine, 1.0))
                marks.append(time.thread_time())
                packet = pack(world, seen, 1.0, quality.packing, memory=memory)
                marks.append(time.thread_time())
                drawing[0] = 0.0
                renderer.draw(packet)
                marks.append(time.thread_time())
                spent = np.diff(marks)
                spent[-1] -= drawing[0]
                context.finish()
                rows.append([*spent, spent.sum(), drawing[0], time.process_time() - whole])
    return dict(zip(ROWS, (1000.0 * np.median(rows[WARM_UP:], axis=0)).tolist(), strict=True))


def _count_processor_time(tally: Any) -> list[float]:
    """Let the counter of drawing calls add up processor time; returns the sum's cell."""
    cell, begin = [0.0], [0.0]

    def enter(_: Any) -> None:
        begin[0] = time.thread_time()

    def leave(_: Any, *fault: object) -> None:
        cell[0] += time.thread_time() - begin[0]

    type(tally).__enter__, type(tally).__exit__ = enter, leave
    return cell


def in_process(checkout: Path, scenario: str, fish: str, options: Any) -> dict[str, float]:
    """As `measured`, by the code of a checkout in a process of its own."""
    command = [sys.executable, __file__, scenario, "--fish", fish, "--child"]
    command += ["--display", options.display, "--frames", str(options.frames)]
    environment = os.environ | {"PYTHONPATH": str(checkout)}
    run = subprocess.run(
        command, env=environment, cwd=checkout, capture_output=True, check=True, text=True
    )
    found: dict[str, float] = json.loads(run.stdout.splitlines()[-1])
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="peaceful")
    parser.add_argument("--fish", default="0", help="numbers of fishes; 0: the scenario's")
    parser.add_argument("--display", default="mono")
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        fish = int(options.fish) or None
        print(json.dumps(measured(options.scenario, fish, options.display, options.frames)))
        return
    checkouts = [HERE, *([options.against.resolve()] if options.against else [])]
    for fish in options.fish.split(","):
        runs: dict[Path, list[dict[str, float]]] = {one: [] for one in checkouts}
        for _ in range(ROUNDS):
            for checkout, found in runs.items():
                found.append(in_process(checkout, options.scenario, fish, options))
        least = [{row: min(one[row] for one in found) for row in ROWS} for found in runs.values()]
        print(f"{options.scenario}, fishes: {fish if int(fish) else 'as in the file'}")
        for row in ROWS:
            print(f"  {row:<16}" + "".join(f"{one[row]:9.2f}" for one in reversed(least)), end="")
            print(f"{least[0][row] / least[-1][row]:9.2f}" if options.against else "")


if __name__ == "__main__":
    main()
