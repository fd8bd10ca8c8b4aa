"""Send random input to the window of a real dive: keys, mouse, wheel, sizes, text.

.venv/bin/python tools/monkey.py [--minutes M] [--seed S] [--keep DIR] [-- DIVE…]

Opens `subsea dive`, with the options after `--`, on a virtual display with a temporary home, and
sends it real events (Xvfb, xdotool). A dive that is left by the menu is opened again. Findings are
any other end, a traceback or a warning, a panel that failed, no picture for STILL_S, memory that
grows by more than GROWTH, and a dive that Ctrl-C does not end. Then the last events are printed,
and all events and the output of the dive are saved in DIR (default monkey-findings). The same seed
sends the same events, each after a picture; the state of the world depends on the speed of the
computer. Exit code 1 if anything was found.
"""

import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import NamedTuple

SCREEN = 800, 600
SIZE = 480, 320  # of the window at the start
BEGUN = 15  # pictures; Esc would end a dive that is still loading
START_S, STILL_S, LEAVE_S = 180.0, 60.0, 60.0
LOOK_S = 1.0  # between two checks of the dive
GROWTH = 0.1  # of resident memory, the most of the last quarter over that of the second
LAST = 40  # events that are printed
PAUSE_S = 0.15  # between two events, on average
FAULT = re.compile(r"Traceback|Warning:|Fatal|Error:|\S+ failed: ")

KEYS = [
    *"abcdefghijklmnopqrstuvwxyz0123456789",
    *("comma", "period", "minus", "plus", "slash"),
    *("Escape", "Tab", "space", "Return", "BackSpace", "Delete", "Home", "End", "Prior", "Next"),
    *("Left", "Right", "Up", "Down", "Left", "Right", "Up", "Down"),
    *(f"F{k}" for k in range(1, 13)),
]
LIKELY = ["Tab", "Escape", "r", "c", "g", "i", "k", "comma", "Return", "space", "w"]
HELD = ["shift", "ctrl", "alt"]
TEXTS = ["0", "-1", "12", "1e9", "nan", "0.5", "monkey", "../a", "", "99999999999", "%s", "ä"]
SHARES = {
    "key": 15, "likely": 15, "with": 3, "hold": 6, "move": 15, "bar": 5, "click": 15, "drag": 12,
    "wheel": 6, "text": 4, "size": 2, "place": 1, "menu": 5, "desk": 8,
}  # fmt: skip


class Event(NamedTuple):
    """Arguments of xdotool, after a pause."""

    pause_s: float
    words: tuple[str, ...]


class Dive(NamedTuple):
    """A running dive and its files."""

    process: subprocess.Popen[bytes]
    pulse: Path  # number of pictures shown
    output: Path


def events(rng: random.Random) -> Iterator[Event]:
    """Endless random events."""
    while True:
        kind = rng.choices([*SHARES], [*SHARES.values()])[0]
        first, *rest = _words(kind, rng)
        yield Event(round(rng.expovariate(1.0 / PAUSE_S), 3), first)
        for words in rest:
            yield Event(round(rng.uniform(0.02, 0.4), 3), words)


def _words(kind: str, rng: random.Random) -> list[tuple[str, ...]]:
    """The steps of one action."""
    x, y = (str(rng.randrange(side)) for side in SCREEN)
    button = rng.choices("123", (6, 1, 2))[0]
    move, bar = ("mousemove", x, y), ("mousemove", str(rng.randrange(SIZE[0])), "8")
    click: list[tuple[str, ...]] = [("mousedown", button), ("mouseup", button)]
    match kind:
        case "key":
            return [("key", rng.choice(KEYS))]
        case "likely":
            return [("key", rng.choice(LIKELY))]
        case "with":
            return [("key", f"{rng.choice(HELD)}+{rng.choice(KEYS)}")]
        case "hold":
            key = rng.choice([*KEYS, *HELD])
            return [("keydown", key), move, ("keyup", key)]
        case "move":
            return [move]
        case "click":
            return [move, *click]
        case "bar":  # of the inspector, which opens panels
            return [bar, *click]
        case "menu":
            keys = rng.choices(("Down", "Up", "Return"), (3, 1, 2), k=rng.randint(2, 9))
            return [("key", "Escape"), *(("key", key) for key in keys)]
        case "desk":
            steps = (_words(rng.choice(("click", "drag", "text")), rng) for _ in range(5))
            return [("key", "Tab"), bar, *click, *chain.from_iterable(steps)]
        case "drag":
            to = tuple(str(rng.randrange(side)) for side in SCREEN)
            return [move, ("mousedown", button), ("mousemove", *to), ("mouseup", button)]
        case "wheel":
            return [("click", "--repeat", str(rng.randint(1, 5)), rng.choice("4567"))]
        case "text":
            return [("key", "ctrl+a"), ("type", "--", rng.choice(TEXTS)), ("key", "Return")]
        case "size":
            odd = [str(rng.choice((1, 64, 200, side))) for side in SCREEN]
            usual = [str(rng.randint(side // 3, 2 * side // 3)) for side in SCREEN]
            window = ("search", "--name", "subsea", "windowsize", "%@")
            return [(*window, *odd), (*window, *usual)]
    window = ("search", "--name", "subsea", "windowmove", "%@")
    return [(*window, x, y), (*window, "0", "0")]


def send(words: tuple[str, ...]) -> None:
    """Run xdotool; a missing window or key has no effect."""
    subprocess.run(["xdotool", *words], timeout=30, check=False, capture_output=True)


def play(
    stream: Iterator[Event],
    seconds: float,
    open_dive: Callable[[], Dive],
    sent: list[Event],
    do: Callable[[tuple[str, ...]], None] = send,
) -> tuple[list[str], list[float]]:
    """Send events for `seconds` or until a finding; also add them to `sent`.

    Returns the findings, and the memory of the dive once a second, MB.
    """
    end, memory, dives = time.monotonic() + seconds, [], 0
    dive: Dive | None = None
    try:
        while time.monotonic() < end:
            dive, dives = open_dive(), dives + 1
            found = _wait_for_start(dive)
            shown, since, looked = _pictures(dive), time.monotonic(), 0.0
            while not found and dive.process.poll() is None and time.monotonic() < end:
                event = next(stream, None)
                if event is None:
                    end = 0.0
                    break
                sent.append(event)
                time.sleep(event.pause_s)
                do(event.words)
                _next_picture(dive)
                if (now := time.monotonic()) - looked < LOOK_S:
                    continue
                looked = now
                if (pictures := _pictures(dive)) != shown:
                    shown, since = pictures, now
                elif now - since > STILL_S:
                    dive.process.send_signal(signal.SIGABRT)  # prints its stack
                    dive.process.wait()
                    found = [f"no picture for {STILL_S:.0f} s"]
                found += _error_lines(dive)
                memory += resident_mb(dive.process.pid)
            if dive.process.poll() is None and not found:
                found = _end_by_ctrl_c(dive)
            elif not found and dive.process.returncode:
                found = [f"it ended with {dive.process.returncode}"]
            found = list(dict.fromkeys(found + _error_lines(dive)))
            print(f"dive {dives}: {len(sent)} events so far, {shown} pictures in it")
            if found:
                return found, memory
    finally:
        if dive is not None and dive.process.poll() is None:
            dive.process.kill()
            dive.process.wait()
    return growth(memory), memory


def growth(memory_mb: list[float]) -> list[str]:
    """The growth of memory, if it is too large."""
    quarter = len(memory_mb) // 4
    if quarter == 0:
        return []
    grown = max(memory_mb[-quarter:]) / max(memory_mb[quarter : 2 * quarter]) - 1.0
    return [f"memory grew by {grown:.0%}"] if grown > GROWTH else []


def resident_mb(process: int) -> list[float]:
    """Read the resident memory of a process, MB, as a list; empty if it has ended."""
    try:
        status = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return []
    return [int(kb) / 1024 for kb in re.findall(r"^VmRSS:\s*(\d+)", status, re.MULTILINE)]


def _wait_for_start(dive: Dive) -> list[str]:
    """Wait for the first pictures; return a finding without."""
    end = time.monotonic() + START_S
    while dive.process.poll() is None and time.monotonic() < end:
        if _pictures(dive) >= BEGUN:
            return []
        time.sleep(0.1)
    return ["it never showed a picture"]


def _next_picture(dive: Dive) -> None:
    """Wait a moment for the next picture; faster events would fall into the same one."""
    end, before = time.monotonic() + LOOK_S, _pictures(dive)
    while time.monotonic() < end and dive.process.poll() is None and _pictures(dive) == before:
        time.sleep(0.005)


def _end_by_ctrl_c(dive: Dive) -> list[str]:
    """End the dive by Ctrl-C; return findings."""
    dive.process.send_signal(signal.SIGINT)
    try:
        code = dive.process.wait(LEAVE_S)
    except subprocess.TimeoutExpired:
        return ["Ctrl-C does not end it"]
    return [] if code in (0, 130) else [f"Ctrl-C ends it with {code}"]


def _error_lines(dive: Dive) -> list[str]:
    """Printed lines that look like an error."""
    text = dive.output.read_text(encoding="utf-8", errors="replace")
    return [line for line in text.splitlines() if FAULT.search(line)]


def _pictures(dive: Dive) -> int:
    try:
        return int(dive.pulse.read_text() or 0)
    except OSError:
        return 0


@contextmanager
def virtual_display() -> Iterator[str]:
    """Start a virtual X display; yield its name."""
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{SCREEN[0]}x{SCREEN[1]}x24"]
    # -noreset: otherwise the server restarts whenever the last window closes.
    server = subprocess.Popen(
        [*command, "-nolisten", "tcp", "-noreset"], pass_fds=[write],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(write)
    try:
        with os.fdopen(read) as pipe:
            yield f":{pipe.readline().strip()}"
    finally:
        server.terminate()
        server.wait()


def opener(home: Path, options: list[str]) -> Callable[[], Dive]:
    """A function that opens a dive with a home folder of its own."""
    cache = os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))  # keep the disk cache
    environment = os.environ | {"HOME": str(home), "XDG_CACHE_HOME": cache}
    for name in ("XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_PICTURES_DIR", "WAYLAND_DISPLAY"):
        environment.pop(name, None)
    pulse, output = home / "pulse", home / "output"
    size = "x".join(map(str, SIZE))
    command = [sys.executable, "-X", "faulthandler", __file__, "--child", str(pulse)]
    command += ["dive", "--size", size, "--quality", "low", *options]

    def open_dive() -> Dive:
        pulse.write_text("0")
        with output.open("wb") as file:
            process = subprocess.Popen(
                command, env=environment, cwd=home, stdout=file, stderr=subprocess.STDOUT
            )
        return Dive(process, pulse, output)

    return open_dive


def child(pulse: Path, options: list[str]) -> int:
    """Run the dive and count its pictures."""
    import glfw

    from subsea.cli.main import main

    swap, shown = glfw.swap_buffers, iter(range(1, sys.maxsize))
    beat = pulse.with_suffix(".next")

    def swapped(handle: object) -> None:
        swap(handle)
        beat.write_text(str(next(shown)))
        beat.replace(pulse)

    glfw.swap_buffers = swapped
    return main(options)


def written(sent: list[Event]) -> str:
    """Events as lines of text."""
    return "".join(f"{event.pause_s}\t" + "\t".join(event.words) + "\n" for event in sent)


def main() -> int:
    """Run from the command line; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0, help="default 10")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, default=Path("monkey-findings"), metavar="DIR")
    parser.add_argument("dive", nargs="*", metavar="DIVE", help="after --: options of the dive")
    options = parser.parse_args()
    stream = events(random.Random(options.seed))
    sent: list[Event] = []
    with virtual_display() as display, tempfile.TemporaryDirectory() as folder:
        os.environ["DISPLAY"] = display
        home, before = Path(folder), time.monotonic()
        found, memory = play(stream, 60.0 * options.minutes, opener(home, options.dive), sent)
        print(f"{len(sent)} events in {time.monotonic() - before:.0f} s")
        if memory:
            first, last = memory[len(memory) // 4], memory[-1]
            print(f"memory: {first:.0f} MB after a quarter, {last:.0f} at the end")
        if found:
            options.keep.mkdir(parents=True, exist_ok=True)
            saved = options.keep / f"monkey-{options.seed}.tsv"
            saved.write_text(written(sent))
            shutil.copy(home / "output", saved.with_suffix(".txt"))
            print("the last events:", *written(sent[-LAST:]).splitlines(), sep="\n  ")
            print(*found, f"saved: {saved} and .txt", sep="\n")
    print("findings" if found else "sound")
    return 1 if found else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        sys.exit(child(Path(sys.argv[2]), sys.argv[3:]))
    sys.exit(main())
