"""Measure the time that a dive takes to open, part by part.

.venv/bin/python tools/measure_start.py [SCENARIO] [--times N] [--against CHECKOUT] [--first]

Opens the dive N times at 1280x720, quality `low`, in separate processes, each time with an empty
disk cache ("nothing cached") and with the cache of the time before ("warm"); with --against also
another checkout, with its own code and cache, in turn. With --first once more without compiled
kernels: a minute or more each.

Figures are seconds since the start of the process, the least of N: processor time of all its
threads and child processes, and elapsed time, which is meaningful only on an idle computer. Needs a
display.
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
AT_REST = "the sea is shown at rest"


def child(scenario: str, begin: float) -> None:
    """Open the dive in this process; print the times of its messages and of its pictures."""
    marks: list[tuple[str, float, float]] = []

    def mark(what: str) -> None:
        marks.append((what, sum(os.times()[:4]), time.monotonic() - begin))

    from subsea.base import progress as console
    from subsea.cli.main import main

    mark("the interpreter")
    say = console.say

    def noted(message: str) -> None:
        mark(re.split("[:(]", message)[0].strip())
        say(message)

    console.say = noted
    import glfw

    swap = glfw.swap_buffers

    def swapped(handle: Any) -> None:
        swap(handle)
        mark("shown")

    glfw.swap_buffers = swapped
    main(["dive", "--scenario", scenario, "--quality", "low", "--seconds", "0.1"])
    print(json.dumps(marks))


def opened(checkout: Path, scenario: str, **places: str) -> dict[str, tuple[float, float]]:
    """End of each part of a start: processor time and elapsed time, s."""
    environment = os.environ | {"PYTHONPATH": str(checkout)} | places
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, __file__, scenario, "--child", str(time.monotonic())]
    run = subprocess.run(
        command, env=environment, cwd=checkout, capture_output=True, check=True, text=True
    )
    marks = json.loads(run.stdout.splitlines()[-1])
    last = max(k for k, (what, *_) in enumerate(marks) if what != "shown")
    done: dict[str, tuple[float, float]] = {}
    now = "importing modules"
    for what, *times in marks[: last + 1]:
        if what == "shown":
            done.setdefault("the window shows something", tuple(times))
        elif what == "the interpreter":
            done[what] = tuple(times)
        else:
            done[now] = tuple(times)
            now = what
    woken = next(k for k, (what, *_) in enumerate(marks) if what == "waking the fishes")
    if marks[woken + 1][0] == "shown":  # not before there was a picture of the sea at rest
        done[AT_REST] = tuple(marks[woken + 1][1:])
    done[PICTURE] = tuple(marks[last + 2][1:])  # after the window and the last message
    return done


def least(runs: list[dict[str, tuple[float, float]]]) -> dict[str, tuple[float, float]]:
    """The least of both times of each part."""
    return {
        what: (min(run[what][0] for run in runs), min(run[what][1] for run in runs))
        for what in runs[0]
        if all(what in run for run in runs)  # only the first may have compiled
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="peaceful")
    parser.add_argument("--times", type=int, default=3)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--first", action="store_true")
    parser.add_argument("--child", type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child is not None:
        child(options.scenario, options.child)
        return
    runs: dict[str, list[dict[str, tuple[float, float]]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for number, checkout in enumerate([HERE, *([options.against] if options.against else [])]):
            if options.first:
                kernels, cache = f"{folder}/kernels{number}", f"{folder}/first{number}"
                places = {"NUMBA_CACHE_DIR": kernels, "XDG_CACHE_HOME": cache}
                name = f"the very first{f' of {checkout}' if number else ''}"
                runs[name] = [opened(checkout, options.scenario, **places)]
        for number in range(options.times):
            cache = {"XDG_CACHE_HOME": f"{folder}/{number}"}
            for name in ("nothing cached", "warm"):
                runs.setdefault(name, []).append(opened(HERE, options.scenario, **cache))
            if options.against:
                other = {"XDG_CACHE_HOME": f"{folder}/other"}
                if not number:  # compiles, and fills its cache
                    opened(options.against, options.scenario, **other)
                found = opened(options.against, options.scenario, **other)
                runs.setdefault(str(options.against), []).append(found)
    for name, those in runs.items():
        print(f"\n{name}{'processor':>{62 - len(name)}}{'clock':>10}")
        for what, (cpu, clock) in least(those).items():
            print(f"  until {what:46s}{cpu:8.2f} s{clock:8.2f} s")
    if options.against:
        warm, other = (least(runs[name])[PICTURE] for name in ("warm", str(options.against)))
        print(f"\n{options.against} over here, warm: {other[0] / warm[0]:.2f} by processor time")


if __name__ == "__main__":
    main()
