"""Measure in turn, so that other programs on the computer disturb all figures alike.

A tool measures by a function of its options that returns figures by name, and runs by `main`, which
adds the options --against FOLDER and --times N.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent

Figures = Mapping[str, float]


def fastest_ms(
    work: Callable[[], object], clock: Callable[[], float] = time.process_time, repeats: int = 5
) -> float:
    """Measure the least time of ``work`` by a clock, ms; the first run compiles and is left out."""
    work()
    durations = []
    for _ in range(repeats):
        start = clock()
        work()
        durations.append(clock() - start)
    return 1000.0 * min(durations)


def picture_size(text: str) -> tuple[int, int]:
    """Read a size such as 1280x720."""
    width, height = map(int, text.split("x"))
    return width, height


def least(runs: list[Figures]) -> Figures:
    """Take the least of each figure that all runs have."""
    return {
        name: min(run[name] for run in runs) for name in runs[0] if all(name in r for r in runs)
    }


def main(
    parser: argparse.ArgumentParser,
    measure: Callable[[argparse.Namespace], Figures],
    times: int,
) -> None:
    """Print the least figures of `measure`, and with --against their ratio to another version's.

    Each run is a process of its own. It runs the tool of this folder with the program of the folder
    that it measures.
    """
    parser.add_argument("--against", type=Path, metavar="FOLDER", help="of another version")
    parser.add_argument("--times", type=int, default=times, metavar="N", help=f"runs ({times})")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        print(json.dumps(measure(options)))
        return
    folders = [HERE, *([options.against.resolve()] if options.against else [])]
    runs: dict[Path, list[Figures]] = {folder: [] for folder in folders}
    for _ in range(options.times):
        for folder, figures in runs.items():
            done = subprocess.run(
                [sys.executable, Path(sys.argv[0]).resolve(), *sys.argv[1:], "--child"],
                cwd=folder, env=os.environ | {"PYTHONPATH": str(folder)},
                stdout=subprocess.PIPE, text=True, check=True,
            )  # fmt: skip
            figures.append(json.loads(done.stdout.splitlines()[-1]))
    here, *others = (least(figures) for figures in runs.values())
    if others:
        print(f"{'':48s}{'here':>10s}{'there':>10s}{'there / here':>14s}")
    for name, figure in here.items():
        there = others[0].get(name) if others else None
        ratio = "" if there is None else f"{there:10.2f}{there / figure:14.2f}"
        print(f"{name:48s}{figure:10.2f}{ratio}")
