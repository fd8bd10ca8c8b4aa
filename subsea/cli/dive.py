"""`subsea dive`: pilot the submarine in a window."""

import argparse
import gc
import os
import sys
from argparse import ArgumentTypeError, Namespace
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subsea.base.command_line import add_command, number_reader
from subsea.base.errors import UserError
from subsea.dive import arguments as shared
from subsea.dive.part import part_kinds, planned, with_parts

if TYPE_CHECKING:
    from subsea.dive.options import DiveOptions
    from subsea.dive.settings import Settings


GROUP = "dive and film"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "dive",
        "pilot the submarine in a window",
        "Point to look, hold the left button to go there, press the space bar to stop. H lists\n"
        "the controls, Esc opens the menu.",
        [
            "subsea dive",
            "subsea dive --fullscreen --seed 3",
            "subsea dive --display side-by-side --screen-width 120 --comfort 1",
            "subsea dive --theatre three-projectors --shrink 4",
        ],
    )
    shared.add(parser, *shared.SCENARIO, "display", "theatre", "shrink")
    shared.add(parser, *shared.STEREO, *shared.SURROUND, "size")
    shared.add_quality(parser, "auto")
    shared.add(parser, "target-ms")
    parser.add_argument(
        "--fullscreen",
        action=argparse.BooleanOptionalAction,
        help="fill the screen (F11 toggles)",
    )
    parser.add_argument(
        "--tour",
        metavar="NAME",
        help="tour of the scenario, directed (the camera of its directions) or auto; pauses while "
        "somebody steers",
    )
    parser.add_argument(
        "--attract",
        type=number_reader(float, 0, 1440),
        metavar="MIN",
        help="minutes without input until a tour begins; 0: never",
    )
    shared.add(parser, "fish", "seed")
    parser.add_argument(
        "--seconds", type=number_reader(float, 0.1, 86400), metavar="S", help="quit after S seconds"
    )
    shared.add(parser, *shared.DRAWING)
    parser.add_argument(
        "--pace",
        type=_pace,
        metavar="RATE",
        help="speed of time: 0 (paused), 0.25, 0.5, 1, 2 or 4",
    )
    parser.add_argument(
        "--settings",
        type=Path,
        metavar="FILE",
        help="settings file (default: see `subsea settings`)",
    )
    group = parser.add_argument_group("on a fish", "as by keys in a dive: docs/how-to/ride.md")
    shared.add(group, "follow")
    group.add_argument("--eyes", metavar="FISH", help="look through its eyes")
    shared.add(group, "gaze")
    group.add_argument(
        "--look",
        choices=("colours", "identity", "range"),
        help="content of its retina images",
    )
    group.add_argument("--reins", action="store_true", help="steer the fish")
    shared.add(group, "see-brightness")
    for kind in part_kinds():
        kind.add_options(parser)
    # Options that are not given come from the settings.
    parser.set_defaults(run=run, display=None, quality=None)


def _pace(text: str) -> float:
    if text not in ("0", "0.25", "0.5", "1", "2", "4"):
        raise ArgumentTypeError(f"{text!r}: expected 0, 0.25, 0.5, 1, 2 or 4")
    return float(text)


def run(options: Namespace) -> int:
    """Open the window and dive."""
    # Must be set before numpy is loaded: OpenBLAS starts a busy-waiting thread for each core.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from msgspec.structs import replace

    from subsea.base.progress import say
    from subsea.dive.settings import read_settings, settings_path, usual_settings
    from subsea.scenario.load import scenario_file

    messages: list[str] = []
    file = options.settings
    settings = usual_settings(messages.append) if file is None else read_settings(file)
    for line in messages:
        say(line)
    notes = [line.replace(f"{settings_path().parent}/", "") for line in messages]
    if options.attract is not None:
        settings = replace(settings, attract=replace(settings.attract, after_min=options.attract))
    _fill_from_settings(options, settings)
    chosen = with_parts(options, _dive_options(options, settings))
    for part in chosen.parts:
        if (code := part.instead(chosen, options.words)) is not None:
            return code
    chosen = planned(chosen)
    with ExitStack() as undo:
        opening = None
        scenario = scenario_file(chosen.scenario)
        # Report a misspelt name before a window appears.
        if scenario.is_file() and not any(part.waits for part in chosen.parts):
            from subsea.ui.first_picture import FirstPicture, picture_name
            from subsea.ui.open_windows import open_windows
            from subsea.view.display_rigs import HEADSET
            from subsea.view.stereo import PAGED

            display = chosen.display
            first = None
            if display.mode not in (PAGED, HEADSET):
                shown = display.mode, display.size, display.fullscreen, display.stereo
                about = (chosen.seed, chosen.fish, *shown, display.surround)
                place = scenario if display.mode == "mono" else None
                shape = display.size[0] / display.size[1]
                name = picture_name(scenario, chosen.changes, about)
                first = FirstPicture(name, place, shape)
            opening = open_windows(
                display.mode, display.size, display.fullscreen, chosen.settings, first=first
            )
            undo.callback(opening.close)
        fresh = "subsea.ui.dive" not in sys.modules
        gc.disable()
        from subsea.ui.dive import dive  # takes longer to load than everything before

        if fresh:  # modules stay: exclude their objects from garbage collection
            gc.freeze()
        gc.enable()
        return dive(chosen, opening, notes)


def _fill_from_settings(options: Namespace, settings: "Settings") -> None:
    display = settings.display
    usual: dict[str, Any] = {"quality": display.quality, "display": "mono", "fullscreen": False}
    if options.theatre is None:  # a theatre file defines its own windows
        usual |= {"display": display.mode, "size": display.size, "fullscreen": display.fullscreen}
    for name, value in usual.items():
        if getattr(options, name) is None:
            setattr(options, name, value)


def _dive_options(options: Namespace, settings: "Settings") -> "DiveOptions":
    """Group the options; a UserError for those that contradict each other."""
    from subsea.dive.options import DisplayOptions, DiveOptions, StartOptions
    from subsea.dive.settings import settings_path

    shared.check_target(options)
    if options.follow and options.eyes:
        raise UserError("dive: --follow looks from behind, --eyes from within: expected one")
    if not (options.follow or options.eyes):
        names = ("gaze", "look", "reins")
        shared.refuse(options, names, "dive: {} needs --eyes FISH or --follow FISH")
    shared.settle_size(options)
    given = Namespace(**vars(options), mode=options.display, diagrams=options.show)
    given.stereo, given.surround = shared.optics(options)
    given.colours, given.teleop = options.look, options.reins
    given.display, given.start = (
        kind(**shared.fields_of(kind, given)) for kind in (DisplayOptions, StartOptions)
    )
    given.settings_file, given.settings = options.settings or settings_path(), settings
    return DiveOptions(**shared.fields_of(DiveOptions, given))
