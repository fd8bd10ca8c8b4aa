"""`subsea dive`: the submarine in a window, or in several."""

import time
from collections.abc import Sequence
from contextlib import closing, suppress

from subsea.base.interrupts import deferred_interrupts
from subsea.base.language import marked
from subsea.dive.directed_camera import check_tour
from subsea.dive.options import DiveOptions
from subsea.jobs.background import CancelledByUserError
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import find_fish, with_total
from subsea.ui.dive import Dive
from subsea.ui.open_windows import Opening


def dive(options: DiveOptions, opening: Opening | None = None, notes: Sequence[str] = ()) -> int:
    """Dive until the window is closed, the menu says so, or the time is over; exit code 0.

    The parts of the options are planned. `opening` is the windows, if they are open already.
    `notes` are lines to show at first.
    """
    start = options.start
    fish_name = start.follow if start.eyes is None else start.eyes
    # Report an unknown name before a window opens.
    loaded = load_scenario(options.scenario, options.changes)
    scenario = with_total(loaded.scenario, options.fish)
    fish = None if fish_name is None else find_fish(fish_name, scenario)
    if options.tour is not None or options.kiosk:
        check_tour(scenario, options.tour or options.settings.attract.tour)
    # An interrupt raised within compiled code or the window library could be lost.
    with suppress(CancelledByUserError), deferred_interrupts() as check:
        running = Dive(options, opening, check, loaded)
        for line in notes:
            running.overlay.note(line)
        with closing(running):
            if fish is not None:
                running.ride_fish(fish, behind=start.eyes is None)
                running.commands.start_ride(start.gaze, start.colours, start.teleop)
            if start.pace is not None:
                running.commands.set_pace(start.pace)
            begun = last = time.perf_counter()
            while running.window_set.open and (
                options.seconds is None or last - begun < options.seconds
            ):
                check()
                now = time.perf_counter()
                running.frame(now - last)
                last = now
            running.end()
            running.show_message(marked("closing"))  # it may take seconds, and a film is completed
    return 0
