"""Measure the cost of panels in a frame.

.venv/bin/python tools/measure_panels.py [SCENARIO] [--rounds N] [--size WxH]

Opens a dive at quality `low` and draws frames of one tick each: with the inspector closed, with
its bar, with each panel, and with all panels, in turn, for N rounds. Figures are medians of
processor time, ms: of the user interface, by the calling thread and by all threads; and of the
whole frame, by all threads, minus that with a closed inspector in the same round. Needs a display.
"""

import argparse
import time
from collections.abc import Callable
from contextlib import closing

import numpy as np

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.ui.dive import Dive
from subsea.ui.idle_tours import IdleTours
from subsea.ui.panels import PANELS
from subsea.world.world import TICK_S

SETTLE = 3  # frames after a panel was opened that are not counted
COUNTED = 3  # frames of each choice in a round


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="peaceful")
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--size", default="1280x720")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    display = DisplayOptions(size=(width, height), quality="low")
    with closing(Dive(DiveOptions(options.scenario, display=display))) as dive:
        show(measured(dive, options.rounds))


def measured(dive: Dive, rounds: int) -> dict[str, list[tuple[float, float, float]]]:
    """Seconds of the overlay, by one thread and by all, and of frames, by choice of panels."""
    choices = {"closed": None, "the bar": set[str]()}
    choices |= {name: {name} for name in PANELS} | {"all of them": set(PANELS)}
    dive.inspector.chosen = 0
    over = timed(dive)
    found: dict[str, list[tuple[float, float, float]]] = {name: [] for name in choices}
    for _ in range(rounds):
        for name, shown in choices.items():
            if dive.inspector.open != (shown is not None):
                dive.inspector.toggle()
            dive.inspector.shown = shown or set()
            for number in range(SETTLE + COUNTED):
                dive.picture._context.finish()
                start = time.process_time()
                dive.frame(TICK_S)
                dive.picture._context.finish()
                whole = time.process_time() - start
                if number >= SETTLE:
                    found[name].append((*over(), whole))
    return found


def timed(dive: Dive) -> Callable[[], tuple[float, float]]:
    """Time all that is drawn over the picture; returns a function for the last frame's times."""
    write, last = dive.text.draw, (0.0, 0.0)

    def written(elapsed_s: float, tours: IdleTours) -> None:
        nonlocal last
        dive.picture._context.finish()
        own, all_of = time.thread_time(), time.process_time()
        write(elapsed_s, tours)
        own = time.thread_time() - own
        dive.picture._context.finish()
        last = own, time.process_time() - all_of

    dive.text.draw = written  # type: ignore[method-assign]
    return lambda: last


def show(found: dict[str, list[tuple[float, float, float]]]) -> None:
    """Print the table."""
    closed = np.array(found["closed"])
    print(f"{'ms':24s}{'calling thread':>16s}{'all threads':>14s}{'the frame':>12s}")
    for name, times in found.items():
        those = 1000.0 * np.array(times)
        more = np.median(those[:, 2] - 1000.0 * closed[:, 2])
        own, all_of = np.median(those[:, :2] - 1000.0 * np.median(closed[:, :2], axis=0), axis=0)
        if name == "closed":
            own, all_of, more = np.median(those, axis=0)
            print(f"{name:24s}{own:16.2f}{all_of:14.2f}{more:12.1f}")
        else:
            print(f"{name:24s}{own:+16.2f}{all_of:+14.2f}{more:+12.1f}")


if __name__ == "__main__":
    main()
