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
    size = tuple(map(int, options.size.split("x")))
    display = DisplayOptions(size=size, quality="low")
    with closing(Dive(DiveOptions(options.scenario, display=display))) as dive:
        show(measured(dive, options.rounds))


def measured(dive: Dive, rounds: int) -> dict[str, list[tuple[float, float, float]]]:
    """Measure seconds of the overlay, by one thread and by all, and of frames, for each choice."""
    choices = {"closed": None, "the bar": set[str]()}
    choices |= {name: {name} for name in PANELS} | {"all of them": set(PANELS)}
    dive.inspector.chosen = 0
    over = timed(dive)
    times: dict[str, list[tuple[float, float, float]]] = {name: [] for name in choices}
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
                    times[name].append((*over(), whole))
    return times


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


def show(times: dict[str, list[tuple[float, float, float]]]) -> None:
    """Print the table: for panels the difference to a closed inspector."""
    closed = 1000.0 * np.array(times["closed"])
    print(f"{'ms':24s}{'calling thread':>16s}{'all threads':>14s}{'the frame':>12s}")
    print(f"{'closed':24s}{'{:16.2f}{:14.2f}{:12.1f}'.format(*np.median(closed, axis=0))}")
    for name in [*times][1:]:
        more = 1000.0 * np.array(times[name]) - [*np.median(closed[:, :2], axis=0), 0.0]
        more[:, 2] -= closed[:, 2]  # of the frame in the same round
        print(f"{name:24s}{'{:+16.2f}{:+14.2f}{:+12.1f}'.format(*np.median(more, axis=0))}")


if __name__ == "__main__":
    main()
