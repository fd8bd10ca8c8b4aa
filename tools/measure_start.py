"""How long a dive takes to open, part by part.

.venv/bin/python tools/measure_start.py [SCENARIO] [--times N] [--against CHECKOUT] [--first]

Opens the dive N times at 1280x720, quality `low`, in processes of their own, each time both with
an empty folder for what is kept on the disk ("nothing kept") and with what the time before left
there ("warm"); with --against also that of another checkout, with its own code and what it keeps,
in turn. With --first once more with no compiled kernels either: a minute or more each.

Figures are seconds since the process was started, by processor time of all its threads and of the
processes it began, and by the clock, which means something only if nothing else runs; the least of
N. Needs a display.
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
PICTURE = "the first picture"


def child(scenario: str, begin: float) -> None:
    """Open the dive in this process; print when what was told, and when the first picture came."""
    marks: list[tuple[str, float, float]] = []

    def mark(what: str) -> None:
        marks.append((what, sum(os.times()[:4]), time.monotonic() - begin))

    from subsea.cli.main import main
    from subsea.core import console

    mark("the interpreter")
    say = console.say

    def told(message: str) -> None:
        mark(re.split("[:(]", message)[0].strip())
        say(message)

    console.say = told
    import glfw

    swap = glfw.swap_buffers

    def swapped(handle: Any) -> None:
        swap(handle)
        mark("shown")

    glfw.swap_buffers = swapped
    main(["dive", "--scenario", scenario, "--quality", "low", "--seconds", "0.1"])
    print(json.dumps(marks))


def opened(checkout: Path, scenario: str, **places: str) -> dict[str, tuple[float, float]]:
    """When each part of a start was done: processor time and time by the clock, s."""
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
    done[PICTURE] = tuple(marks[last + 2][1:])  # before it comes what was told last
    return done


def least(runs: list[dict[str, tuple[float, float]]]) -> dict[str, tuple[float, float]]:
    """Of each part the least of both times."""
    return {
        what: (min(run[what][0] for run in runs), min(run[what][1] for run in runs))
        for what in runs[0]
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
                kernels, kept = f"{folder}/kernels{number}", f"{folder}/first{number}"
                places = {"NUMBA_CACHE_DIR": kernels, "XDG_CACHE_HOME": kept}
                name = f"the very first{f' of {checkout}' if number else ''}"
                runs[name] = [opened(checkout, options.scenario, **places)]
        for number in range(options.times):
            kept = {"XDG_CACHE_HOME": f"{folder}/{number}"}
            runs.setdefault("nothing kept", []).append(opened(HERE, options.scenario, **kept))
            runs.setdefault("warm", []).append(opened(HERE, options.scenario, **kept))
            if options.against:
                other = {"XDG_CACHE_HOME": f"{folder}/other"}
                if not number:  # it compiles, and keeps what it keeps
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
