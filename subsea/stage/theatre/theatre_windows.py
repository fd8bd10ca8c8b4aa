"""The windows of a theatre."""

from collections.abc import Callable

from subsea.dive.options import DisplayOptions, TheatreOptions
from subsea.dive.pilot import Pilot
from subsea.dive.tick_source import TickSource, tick_source_maker
from subsea.stage.theatre.theatre_setup import set_up_theatre, view_parts
from subsea.ui.monitors import Installation, Screen
from subsea.world.world import World


def theatre_windows(
    theatre: TheatreOptions, display: DisplayOptions, leads: bool = False
) -> tuple[Installation, Callable[[World, Pilot], TickSource]]:
    """The rig and windows of a theatre, and the maker of its tick source.

    A master that `leads` has its nodes open the scenarios that it shows.
    """
    setup = set_up_theatre(theatre.name, display.mode, display.stereo, theatre.node, theatre.shrink)
    view = {}
    if theatre.node is not None:
        view = view_parts(theatre.name, display.mode, display.stereo)
    make_ticks = tick_source_maker(
        setup.theatre, setup.path, theatre.node, view, theatre.resumes, leads
    )
    screens = [
        Screen(window.name, window.size, window.position, window.monitor)
        for window in setup.windows
    ]
    return Installation(setup.rig, screens, str(setup.path), setup.loudspeakers), make_ticks
