"""Measure the host's share of a frame: everything but the drawing calls.

LP_NUM_THREADS=1 .venv/bin/python tools/measure_host.py [SCENARIO] [--fish N] [--against FOLDER]

Figures are processor time of the calling thread, ms a frame, medians: the tick, the views, packing,
and the renderer without its drawing calls; then the drawing calls, and all threads.
"""

import argparse
import time
from typing import Any

import numpy as np

from tools.measuring import Figures, main

WARM_UP = 30
ROWS = ("tick", "views", "pack", "renderer", "host", "drawing calls", "all threads")


def measured(options: argparse.Namespace) -> Figures:
    """Measure the parts of frames; returns medians, ms."""
    from subsea.dive.start import headless, picture_maker, start_world
    from subsea.dive.tour import Tour
    from subsea.frame.packet import pack
    from subsea.rendering.output.quality import PRESETS
    from subsea.view.display_rigs import cockpit, display_rig
    from subsea.view.levels import empty_lod_state
    from subsea.view.rig import views
    from subsea.world.step import step

    quality, rig, tour = PRESETS["low"], display_rig(options.display, (1280, 720)), Tour()
    rows = []
    with headless() as context:
        world = start_world(options.scenario, fish=options.fish, tell=lambda message: None)
        drawing = count_processor_time(context.extra)
        memory = empty_lod_state(len(world.state.fishes.species))
        with picture_maker(context, world, rig, quality) as renderer:
            for _ in range(WARM_UP + options.frames):
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


def count_processor_time(tally: Any) -> list[float]:
    """Let the counter of drawing calls add up processor time; returns the cell of the sum."""
    cell, begin = [0.0], [0.0]

    def enter(_: Any) -> None:
        begin[0] = time.thread_time()

    def leave(_: Any, *fault: object) -> None:
        cell[0] += time.thread_time() - begin[0]

    type(tally).__enter__, type(tally).__exit__ = enter, leave
    return cell


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="peaceful")
    parser.add_argument("--fish", type=int, help="number of fishes (the scenario's)")
    parser.add_argument("--display", default="mono")
    parser.add_argument("--frames", type=int, default=60)
    main(parser, measured, times=4)
