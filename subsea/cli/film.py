"""`subsea film`: film a tour, or the view of a fish, without a window."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from subsea.cli import options as shared
from subsea.core.command_line import add_command, number_reader
from subsea.core.errors import UserError


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "film",
        "film a tour, without a window",
        "The name OUT decides the kind: a film (.mp4), one picture (.png), or a folder of\n"
        "numbered pictures, which continues an interrupted one. Needs OpenGL, but no display.",
        [
            "subsea film dive.mp4",
            "subsea film reef.png --size 1920x1080 --seconds 8",
            "subsea film frames/ --seconds 2 --fps 30",
            "subsea film theatre.mp4 --theatre three-projectors",
            "subsea film springs.png --show scaffold,school --wireframe",
            "subsea film seen/ --eyes clownfish --size 320x240 --seconds 4",
        ],
    )
    parser.add_argument("out", metavar="OUT", type=Path, help="FILE.mp4, FILE.png or a folder")
    shared.add_scenario(parser)
    shared.add_display(parser)
    shared.add_stereo(parser)
    shared.add_surround(parser)
    parser.add_argument(
        "--seconds",
        type=number_reader(float, 0.05, 3600),
        metavar="S",
        help="length of the film; a single picture shows its end (default 10, or to the end of a "
        "named tour or of the directions)",
    )
    parser.add_argument(
        "--tour",
        default="auto",
        metavar="NAME",
        help="one of the scenario's tours, directed (the camera of its directions), or auto, which "
        "goes where something happens (default auto)",
    )
    parser.add_argument(
        "--start",
        type=number_reader(float, 0.0, 86400.0),
        default=0.0,
        metavar="S",
        help="seconds of the dive before the film begins (default 0)",
    )
    parser.add_argument(
        "--fps",
        type=number_reader(float, 1, 240),
        default=30.0,
        metavar="F",
        help="pictures per second (default 30)",
    )
    shared.add_size(parser)
    shared.add_quality(parser, "high", automatic=False)
    shared.add_seed(parser)
    shared.add_drawing(parser)
    shared.add_follow(parser)
    _add_eyes(parser)
    shared.add_theatre(parser)
    parser.set_defaults(run=run)


def _add_eyes(parser: ArgumentParser) -> None:
    group = parser.add_argument_group(
        "what a fish sees", "labelled frames in the folder OUT; docs/fish-view.md explains them"
    )
    group.add_argument(
        "--eyes",
        metavar="FISH",
        help="a fish by its number, its species, or SPECIES:NUMBER counted from 0: pictures of "
        "both its eyes, identity and depth maps, and camera.json",
    )
    shared.add_gaze(group)
    group.add_argument(
        "--field",
        type=number_reader(float, 20.0, 150.0),
        metavar="DEG",
        help="angle of view of a retina from left to right (default 90)",
    )
    shared.add_see_brightness(group)


def run(options: Namespace) -> int:
    """Film the tour, or the view of a fish."""
    if options.eyes is not None:
        return _film_eyes(options)
    names = ("gaze", "field", "see_brightness")
    shared.refuse(options, names, "film: {} needs --eyes FISH")
    from subsea.media.film import film
    from subsea.media.film_options import TourFilmOptions

    shared.check_display_without_window(options.display)
    shared.settle_size(options)
    stereo, surround = shared.optics(options)
    return film(
        TourFilmOptions(
            **_common(options),
            display=options.display,
            stereo=stereo,
            surround=surround,
            theatre=options.theatre,
            shrink=options.shrink,
            show=options.show,
            wireframe=options.wireframe,
            follow=options.follow,
        )
    )


def _film_eyes(options: Namespace) -> int:
    from subsea.media.eye_frames import film_eyes
    from subsea.media.film_options import EyeFilmOptions
    from subsea.view.retina import FIELD_DEG, Gaze

    if options.display != "mono":
        raise UserError(
            f"film: --eyes gives a picture for each eye, not --display {options.display}"
        )
    other = ("theatre", "shrink", *shared.STEREO, *shared.SURROUND)
    shared.refuse(options, other, "film: --eyes gives a picture for each eye, not {}")
    drawing = ("show", "wireframe", "follow")
    shared.refuse(options, drawing, "film: --eyes shows what a fish sees, {} shows more")
    shared.settle_size(options)
    return film_eyes(
        EyeFilmOptions(
            **_common(options),
            eyes=options.eyes,
            gaze=Gaze(*(options.gaze or ())),
            field_deg=options.field or FIELD_DEG,
            see_brightness=options.see_brightness,
        )
    )


def _common(options: Namespace) -> dict[str, Any]:
    """The fields of FilmOptions."""
    names = (
        "out", "scenario", "changes", "seed", "tour", "start", "seconds", "fps", "size", "quality",
    )  # fmt: skip
    return {name: getattr(options, name) for name in names}
