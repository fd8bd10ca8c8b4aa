"""`subsea dive`: the submarine in a window, or in several."""

import time
from collections.abc import Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import replace

from subsea.base.errors import UserError
from subsea.base.interrupts import deferred_interrupts
from subsea.base.language import marked
from subsea.base.progress import say
from subsea.dive.directed_camera import check_tour
from subsea.dive.options import DiveOptions
from subsea.dive.pilot import Pilot
from subsea.dive.tick_source import LocalTicks, TickSource, TickSourceMaker
from subsea.jobs.background import CancelledByUserError
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import find_fish, with_total
from subsea.stage.cluster.master_scenario import MasterScenario
from subsea.stage.service import PictureReports, notify
from subsea.stage.show_file import check_for_cluster
from subsea.stage.show_player import ShowScreens
from subsea.ui.dive import Dive
from subsea.ui.monitors import Installation
from subsea.ui.open_windows import Opening
from subsea.world.world import World


def dive(options: DiveOptions, opening: Opening | None = None, notes: Sequence[str] = ()) -> int:
    """Dive until the window is closed, the menu says so, or the time is over; exit code 0.

    `opening` is the windows, if they are open already. `notes` are lines to show at first.
    """
    theatre, start, kiosk = options.theatre, options.start, options.kiosk
    if options.see_brightness and theatre is not None and theatre.node is not None:
        raise UserError("--see-brightness is for one computer: others would not see the same light")
    fish_name = start.follow if start.eyes is None else start.eyes
    if theatre is not None and theatre.node is not None and (fish_name or start.pace is not None):
        option = "--follow" if start.follow else "--eyes" if start.eyes else "--pace"
        raise UserError(f"{option} is for one computer: others would not go along")
    fish = None
    if fish_name is not None or options.tour is not None or kiosk:
        # Report an unknown name before a window opens.
        scenario = with_total(load_scenario(options.scenario, options.changes)[0], options.fish)
        fish = None if fish_name is None else find_fish(fish_name, scenario)
        if options.tour is not None or kiosk:
            check_tour(scenario, options.tour or options.settings.attract.tour)
    show = None
    if options.playlist is not None:
        show = ShowScreens(options.playlist, say)
        options = replace(options, scenario=show.first_scenario)
    installation: Installation | None = None
    make_ticks: TickSourceMaker = LocalTicks
    if theatre is not None:
        from subsea.stage.setup import theatre_windows

        if show is not None and theatre.node is not None:
            from subsea.stage.theatre.load import load_theatre

            cluster = load_theatre(theatre.name)[0].cluster
            if cluster is not None and theatre.node != cluster.master:
                raise UserError(f"--playlist is for the master of the cluster, {cluster.master!r}")
            check_for_cluster(show.show, show.path)
        leads = show is not None or options.console is not None
        installation, make_ticks = theatre_windows(theatre, options.display, leads)
    if show is not None:
        make_ticks = restoring(show, make_ticks)
    # An interrupt raised within compiled code or the window library could be lost.
    with suppress(CancelledByUserError), deferred_interrupts() as check:
        running = Dive(options, installation, make_ticks, opening, check, show)
        if kiosk:
            say(f"a kiosk: {options.settings.kiosk.leave} leaves it, in its window")
        for line in notes:
            running.overlay.note(line)
        if options.console is not None:
            from subsea.stage.console.remote_control import open_console

            open_console(running, options.console)
        with closing(running), ExitStack() as ending:
            ending.callback(notify, STOPPING=1)  # also after a signal
            if fish is not None:
                running.ride_fish(fish, behind=start.eyes is None)
                running.commands.start_ride(start.gaze, start.colours, start.teleop)
            if start.pace is not None:
                running.commands.set_pace(start.pace)
            reports = PictureReports()
            follow = MasterScenario().follow
            begun = last = time.perf_counter()
            while running.window_set.open and (
                options.seconds is None or last - begun < options.seconds
            ):
                check()
                now = time.perf_counter()
                running.frame(now - last)
                follow(running)
                last = now
                reports.update(running.pictures, running.tick_source.waiting or running.source.stem)
            if show is not None:
                show.end()
            running.show_message(marked("closing"))  # it may take seconds, and a film is completed
    return 0


def restoring(show: ShowScreens, make_ticks: TickSourceMaker) -> TickSourceMaker:
    """Ticks of a show, whose first sea goes on where a power cut ended it."""

    def made(world: World, pilot: Pilot) -> TickSource:
        show.restore(world)
        return make_ticks(world, pilot)

    return made
