"""`subsea film`: film a tour, or the view of a fish, without a window."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError
from subsea.dive import arguments as shared

if TYPE_CHECKING:
    from subsea.media.exposure import Exposure

BLUR = "samples", "shutter", "aperture", "focus"  # options of the exposure


GROUP = "dive and film"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "film",
        "film a tour without a window",
        "Writes a film (.mp4), one picture (.png) or a folder of numbered pictures. A folder that\n"
        "an interruption left is completed. Needs OpenGL but no display.",
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
    shared.add(parser, *shared.SCENARIO, "display", *shared.STEREO, *shared.SURROUND)
    parser.add_argument(
        "--seconds",
        type=number_reader(float, 0.05, 3600),
        metavar="S",
        help="length of the film (default 10, or to the end of a named tour or of the directions); "
        "a picture shows its end",
    )
    shared.add(parser, "tour", "start", "fps", "size")
    shared.add_quality(parser, "high", automatic=False)
    shared.add(parser, "fish", "seed", *shared.DRAWING, "follow", "theatre", "shrink")
    parser.add_argument("--mute", action="store_true", help="a film without sound")
    parser.add_argument(
        "--score", action="store_true", help="slow tones under the sound, which follow the sea"
    )
    parser.add_argument(
        "--sound-layout",
        default="stereo",
        metavar="LAYOUT",
        help="of the sound: mono, stereo (default), binaural, quad, 5.1 or 7.1",
    )
    parser.add_argument("--audio", type=Path, metavar="FILE", help="write the sound as FILE.wav")
    parser.add_argument(
        "--audio-stems",
        type=Path,
        metavar="DIR",
        help="write sea, fishes, vessel and score as WAV files into DIR, at full volume",
    )
    add_force(parser)
    blur = parser.add_argument_group(
        "motion blur and depth of field", "each frame is the mean of several pictures"
    )
    blur.add_argument(
        "--samples",
        type=number_reader(int, 1, 256),
        metavar="N",
        help="pictures of a frame (default 1; 16 for a film, 64 for a picture)",
    )
    blur.add_argument(
        "--shutter",
        type=number_reader(float, 0.0, 1.0),
        metavar="SHARE",
        help="of the time between two frames for which the shutter is open (default 0.5)",
    )
    blur.add_argument(
        "--aperture",
        type=number_reader(float, 0.0, 30.0),
        metavar="CM",
        help="diameter of the lens (default 0: everything is sharp)",
    )
    blur.add_argument(
        "--focus",
        type=_focus,
        metavar="CM",
        help="distance that is in focus, or `fish` for that of the followed fish (default 300)",
    )
    group = parser.add_argument_group(
        "what a fish sees",
        "labelled frames in the folder OUT; docs/how-to/fish-frames.md explains them",
    )
    group.add_argument(
        "--eyes",
        metavar="FISH",
        help="the fish, as for --follow; writes images of both eyes, identity and depth maps, and "
        "camera.json",
    )
    shared.add(group, "gaze")
    group.add_argument(
        "--field",
        type=number_reader(float, 20.0, 150.0),
        metavar="DEG",
        help="horizontal angle of view (default 90)",
    )
    shared.add(group, "see-brightness")
    parser.set_defaults(run=run)


def _focus(text: str) -> float:
    """Read the distance of --focus, cm; 0 stands for that of the followed fish."""
    return 0.0 if text == "fish" else float(number_reader(float, 10.0, 10000.0)(text))


def run(options: Namespace) -> int:
    """Film the tour, or the view of a fish."""
    if options.eyes is not None:
        return _film_eyes(options)
    shared.refuse(options, ("gaze", "field", "see-brightness"), "film: {} needs --eyes FISH")
    from subsea.media.film import TourFilmOptions, film
    from subsea.scenario.load import load_scenario

    shared.check_display_without_window(options.display)
    shared.settle_size(options)
    options.stereo, options.surround = shared.optics(options)
    options.exposure = _exposure(options)
    options.loaded = load_scenario(options.scenario, options.changes)
    chosen = TourFilmOptions(**shared.fields_of(TourFilmOptions, options))
    return film(chosen)


def _exposure(options: Namespace) -> "Exposure":
    """The exposure of a frame, as the options say."""
    from subsea.media.exposure import Exposure
    from subsea.view.display_rigs import SURROUNDS

    if options.focus == 0.0 and options.follow is None:
        raise UserError("film: --focus fish needs --follow FISH")
    if (options.samples or 1) == 1:
        shared.refuse(options, BLUR[1:], "film: {} needs --samples N, of 2 or more")
    if options.display in SURROUNDS:
        # The planes in focus of the faces of a cube do not meet.
        shared.refuse(options, ["aperture"], f"film: {{}} is not for --display {options.display}")
    given = options.samples, options.shutter, options.aperture, options.focus
    chosen = zip(Exposure._fields, given, strict=True)
    return Exposure(**{name: value for name, value in chosen if value is not None})


def _film_eyes(options: Namespace) -> int:
    from subsea.media.eye_frames import film_eyes
    from subsea.media.film import EyeFilmOptions
    from subsea.scenario.load import load_scenario
    from subsea.view.retina import FIELD_DEG, Gaze

    shared.refuse(options, BLUR, "film: {} cannot be combined with --eyes")
    if options.display != "mono":
        raise UserError(
            f"film: --eyes gives a picture for each eye, not --display {options.display}"
        )
    other = ("theatre", "shrink", *shared.STEREO, *shared.SURROUND)
    shared.refuse(options, other, "film: --eyes gives a picture for each eye, not {}")
    drawing = ("show", "wireframe", "follow")
    shared.refuse(options, drawing, "film: --eyes shows what a fish sees, {} shows more")
    shared.settle_size(options)
    options.gaze, options.field_deg = Gaze(*(options.gaze or ())), options.field or FIELD_DEG
    options.loaded = load_scenario(options.scenario, options.changes)
    chosen = EyeFilmOptions(**shared.fields_of(EyeFilmOptions, options))
    return film_eyes(chosen)
