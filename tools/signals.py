"""Interrupt commands at random moments, and count how they end.

.venv/bin/python tools/signals.py [NAME...] [--number N] [--first K] [--jobs N]

Starts each command and sends it Ctrl-C or SIGTERM, sometimes twice, between the first line of the
program and its usual end, until N processes of each have received a signal. The window of a dive
opens on a virtual display (Xvfb). A command must end with 0, 1, 2, 75 or 130, within LIMIT_S,
without a stack trace. Prints the counts, and the output of each process that ended in another way;
the exit code is 1 if there was one. Needs Linux.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tools.fuzzing import CODES
from tools.monkey import virtual_display

HERE = Path(__file__).resolve().parent.parent
LIMIT_S = 60.0  # from the signal to the end
FAULTS = "Traceback", "Exception ignored", "KeyboardInterrupt", "Fatal Python error"

# For a folder with a record `run.h5`.
COMMANDS = {
    "film": "subsea film OUT.mp4 --seconds 0.5 --size 96x64",
    "eyes": "subsea film OUT --eyes 0 --seconds 0.5 --size 64x64",
    "simulate": "subsea simulate --seconds 4 --out OUT.h5",
    "study": "subsea study run.h5 --out OUT --json OUT.json",
    "inspect": "capture inspect fusilier",
    "export": "capture export fusilier --to gltf --out OUT",
    "scene": "subsea export peaceful --to usd --out OUT.usdc --seconds 0.5 --with sand --fish 8",
    "dive": "subsea dive --seconds 3 --quality low --size 96x64",
    "benchmark": "subsea benchmark --frames 20 --size 96x64 --json OUT.json",
    "doctor": "subsea doctor",
    "list": "subsea list scenarios",
    "settings": "subsea settings --write --force",
}


def start(name: str, number: int, folder: Path) -> "subprocess.Popen[str]":
    """Start a command in a folder, with results of this number."""
    words = COMMANDS[name].replace("OUT", f"{name}{number}").split()
    return subprocess.Popen(
        [sys.executable, "-m", *words], cwd=folder, env=os.environ | {"PYTHONPATH": str(HERE)},
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def uninterrupted_s(name: str, folder: Path) -> float:
    """The time that a command takes, s."""
    begun = time.monotonic()
    process = start(name, -1, folder)
    printed, _ = process.communicate()
    if process.returncode not in (0, 1):
        raise RuntimeError(printed)
    return time.monotonic() - begun


def wait_for_handlers(process: "subprocess.Popen[str]") -> None:
    """Wait for the first line of the program; before, a signal ends the interpreter."""
    while process.poll() is None:
        status = Path(f"/proc/{process.pid}/status").read_text()
        caught = int(status.partition("SigCgt:")[2].split()[0], 16)
        if caught & 1 << (signal.SIGTERM - 1):
            return
        time.sleep(0.001)


def interrupted(name: str, number: int, seconds: float, folder: Path) -> tuple[str, str]:
    """Interrupt a command within about `seconds`; return how it ended and what it printed."""
    draw = random.Random(f"{name} {number}")
    while True:
        process = start(name, number, folder)
        wait_for_handlers(process)
        time.sleep(draw.uniform(0.0, seconds))
        if process.poll() is None:
            break
        process.communicate()  # ended before the signal: once more
        seconds *= 0.9
    for _ in range(draw.choice((1, 1, 2))):
        process.send_signal(draw.choice((signal.SIGINT, signal.SIGTERM)))
        time.sleep(draw.choice((0.0, 0.05, 0.5)))
    try:
        printed, _ = process.communicate(timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        return "does not end", process.communicate()[0]
    if process.returncode not in CODES:
        return f"ends with {process.returncode}", printed
    if any(fault in printed for fault in FAULTS):
        return "prints a stack trace", printed
    return str(process.returncode), printed


def main() -> int:
    """Print the counts; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=list(COMMANDS), metavar="NAME")
    parser.add_argument("--number", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    # A shell's background job ignores Ctrl-C, and so would its child processes.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    faults = 0
    with (
        virtual_display() as display,
        tempfile.TemporaryDirectory() as place,
        ThreadPoolExecutor(options.jobs) as pool,
    ):
        os.environ["DISPLAY"] = display
        folder = Path(place)
        os.environ |= {f"XDG_{name}_HOME": place for name in ("CONFIG", "DATA")}
        COMMANDS["record"] = "subsea simulate --seconds 20 --out run.h5"
        uninterrupted_s("record", folder)
        for name in options.names:
            seconds = uninterrupted_s(name, folder)
            numbers = range(options.first, options.first + options.number)
            ends = list(
                pool.map(lambda k, name=name, s=seconds: interrupted(name, k, s, folder), numbers)
            )
            for end, printed in ends:
                if not end[0].isdigit():
                    faults += 1
                    print(f"{name} {end}:\n{printed}")
            print(f"{name:10s}{dict(sorted(Counter(end for end, _ in ends).items()))}", flush=True)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
