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
        "Writes a film (.mp4, .mov), one picture (.png, .exr) or a folder of numbered pictures.\n"
        "A folder that an interruption left is completed. Needs OpenGL but no display.",
        [
            "subsea film dive.mp4",
            "subsea film reef.png --size 1920x1080 --seconds 8",
            "subsea film frames/ --seconds 2 --fps 30",
            "subsea film grade.mov",
            "subsea film shot/ --passes all --seconds 2 --fps 24",
            "subsea film theatre.mp4 --theatre three-projectors",
            "subsea film springs.png --show scaffold,school --wireframe",
            "subsea film seen/ --eyes clownfish --size 320x240 --seconds 4",
        ],
    )
    parser.add_argument(
        "out", metavar="OUT", type=Path, help="FILE.mp4, FILE.mov, FILE.png, FILE.exr or a folder"
    )
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
    parser.add_argument(
        "--codec",
        metavar="CODEC",
        help="of a film: h264 (default of .mp4), hevc of 10 bits (.mp4, .mov), or prores, which is "
        "ProRes 4444 (default of .mov)",
    )
    parser.add_argument(
        "--alpha",
        action="store_true",
        help="pictures, or ProRes, with opacity: open water is transparent",
    )
    parser.add_argument("--mute", action="store_true", help="a film without sound")
    parser.add_argument(
        "--score", action="store_true", help="slow tones under the sound, which follow the sea"
    )
    parser.add_argument(
        "--sound-layout",
        default="stereo",
        metavar="LAYOUT",
        help="of the sound: mono, stereo (default), binaural, quad, 5.1, 7.1, or ambisonic, which "
        "turns with the picture in players of 360° films",
    )
    parser.add_argument("--audio", type=Path, metavar="FILE", help="write the sound as FILE.wav")
    parser.add_argument(
        "--audio-stems",
        type=Path,
        metavar="DIR",
        help="write sea, fishes, vessel and score as WAV files into DIR, at full volume",
    )
    add_force(parser)
    light = parser.add_argument_group(
        "passes for compositing",
        "OpenEXR files of linear light; docs/how-to/compositing.md explains them",
    )
    light.add_argument(
        "--passes",
        metavar="LIST",
        help="write OpenEXR with these passes, separated by commas: beauty, water, depth, normal, "
        "motion, cryptomatte, or `all` (OUT.exr without it: beauty)",
    )
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
    options.passes = _passes(options)
    _check_codec(options)
    if options.alpha:
        _check_alpha(options)
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


def _passes(options: Namespace) -> tuple[str, ...]:
    """The passes that the options ask for; () for developed pictures."""
    from subsea.media.frame_writers import kind_of
    from subsea.media.passes import read_passes

    light = options.out.suffix.lower() == ".exr"
    if options.passes is None and not light:
        return ()
    if not light and kind_of(options.out) != "folder":
        raise UserError("--passes needs FILE.exr or a folder", file=options.out)
    if options.display != "mono":
        raise UserError(f"film: OpenEXR is not for --display {options.display}")
    no_light = ("theatre", "show", "wireframe")
    shared.refuse(options, no_light, "film: OpenEXR holds the light of the sea, not {}")
    return read_passes(options.passes or "beauty")


def _check_codec(options: Namespace) -> None:
    """Raise a UserError unless the output can have this codec."""
    from subsea.media.frame_writers import codec_of, kind_of

    if kind_of(options.out) == "film":
        codec_of(options.out, options.codec)
    elif options.codec is not None:
        raise UserError("--codec needs FILE.mp4 or FILE.mov", file=options.out)


def _check_alpha(options: Namespace) -> None:
    """Raise a UserError unless pictures of this kind can have opacity."""
    from subsea.media.frame_writers import ALPHA_PIXELS, codec_of, kind_of

    if options.passes:
        raise UserError("film: --alpha is not for OpenEXR; `--passes water` has subject.A")
    film = kind_of(options.out) == "film"
    if film and codec_of(options.out, options.codec) not in ALPHA_PIXELS:
        raise UserError("film: --alpha needs FILE.mov of ProRes, FILE.png or a folder")
    if options.display != "mono":
        raise UserError(f"film: --alpha is not for --display {options.display}")
    shared.refuse(options, ("theatre", "wireframe"), "film: --alpha is not for {}")


def _film_eyes(options: Namespace) -> int:
    from subsea.media.eye_frames import film_eyes
    from subsea.media.film import EyeFilmOptions
    from subsea.scenario.load import load_scenario
    from subsea.view.retina import FIELD_DEG, Gaze

    film_only = (*BLUR, "passes", "codec", "alpha")
    shared.refuse(options, film_only, "film: {} cannot be combined with --eyes")
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
