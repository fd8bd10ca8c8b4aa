"""Measure the time that a dive takes to open, part by part.

.venv/bin/python tools/measure_start.py [SCENARIO] [--cached all|kernels|nothing] [--against FOLDER]

Opens the dive N times at 1280x720, quality `low`, with what earlier runs have cached: all, only
compiled kernels, or nothing (a minute or more). Figures are seconds since the start of the process,
the least of N: processor time of all its threads and child processes, and elapsed time, which is
meaningful only on an idle computer. Needs a display.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent.parent
PICTURE = "the first picture of a moving sea"


def measured(options: argparse.Namespace) -> dict[str, float]:
    """Open the dive in this process; returns the end of each part, s."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        if options.cached != "all":
            os.environ["XDG_CACHE_HOME"] = folder
        if options.cached == "nothing":
            os.environ["NUMBA_CACHE_DIR"] = folder
        return ends_of_parts(open_dive(options.scenario))


def open_dive(scenario: str) -> list[tuple[str, float, float]]:
    """Open the dive; returns its messages and pictures with processor time and elapsed time, s."""
    ticks = float(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])
    begin = ticks / os.sysconf("SC_CLK_TCK")
    marks: list[tuple[str, float, float]] = []

    def mark(what: str) -> None:
        elapsed = time.clock_gettime(time.CLOCK_BOOTTIME) - begin
        marks.append((what, sum(os.times()[:4]), elapsed))

    from subsea.base import progress
    from subsea.cli.main import main

    mark("the interpreter")
    say = progress.say

    def noted(message: str) -> None:
        mark(re.split("[:(]", message)[0].strip())
        say(message)

    progress.say = noted
    import glfw

    swap = glfw.swap_buffers

    def swapped(handle: Any) -> None:
        swap(handle)
        mark("shown")

    glfw.swap_buffers = swapped
    main(["dive", "--scenario", scenario, "--quality", "low", "--seconds", "0.1"])
    return marks


def ends_of_parts(marks: list[tuple[str, float, float]]) -> dict[str, float]:
    """Turn messages, which come when a part begins, into the ends of the parts."""
    last = max(k for k, (what, *_) in enumerate(marks) if what != "shown")
    done: dict[str, tuple[float, float]] = {}
    part = "importing modules"
    for what, cpu, clock in marks[: last + 1]:
        if what == "shown":
            done.setdefault("the window shows something", (cpu, clock))
        elif what == "the interpreter":
            done[what] = cpu, clock
        else:
            done[part] = cpu, clock
            part = what
    done[PICTURE] = marks[last + 2][1:]  # after the window and the last message
    figures = {f"processor, until {what}": cpu for what, (cpu, _) in done.items()}
    return figures | {f"clock, until {what}": clock for what, (_, clock) in done.items()}


def main() -> None:
    """Print the least figures, and with --against their ratio to another version's.

    Each run is a process of its own. It runs this tool with the program of the folder that it
    measures.
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="peaceful")
    parser.add_argument("--cached", choices=("all", "kernels", "nothing"), default="all")
    parser.add_argument("--against", type=Path, metavar="FOLDER", help="of another version")
    parser.add_argument("--times", type=int, default=3, metavar="N", help="runs (3)")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        print(json.dumps(measured(options)))
        return
    folders = [HERE, *([options.against.resolve()] if options.against else [])]
    runs: dict[Path, list[dict[str, float]]] = {folder: [] for folder in folders}
    for _ in range(options.times):
        for folder, figures in runs.items():
            done = subprocess.run(
                [sys.executable, Path(__file__).resolve(), *sys.argv[1:], "--child"],
                cwd=folder, env=os.environ | {"PYTHONPATH": str(folder)},
                stdout=subprocess.PIPE, text=True, check=True,
            )  # fmt: skip
            figures.append(json.loads(done.stdout.splitlines()[-1]))
    for name in runs[HERE][0]:
        least = [
            min(run[name] for run in figures)
            for figures in runs.values()
            if all(name in run for run in figures)
        ]
        ratio = f"{least[1] / least[0]:14.2f} times as long there" if len(least) == 2 else ""
        print(f"{name:60s}" + "".join(f"{figure:10.2f}" for figure in least) + ratio)


if __name__ == "__main__":
    main()
