"""Options that several commands share: their parsers and the checks between them."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from subsea.core.command_line import number_reader
from subsea.core.errors import UserError

if TYPE_CHECKING:
    from subsea.view.stereo import Stereo
    from subsea.view.surround import Surround

MAX_SIZE = 8192  # pixels; the largest texture of common GPUs
MIN_SIZE = 64
SIZE = 1280, 720  # default
STEREO = "swap_eyes", "eye_distance", "screen_distance", "screen_width", "comfort"
SURROUND = "panorama_angle", "dome_tilt"
# Defined by a theatre file if there is one.
SINGLE_WINDOW = "size", "fullscreen", "screen_distance", "screen_width", *SURROUND


def add_scenario(parser: ArgumentParser) -> None:
    """Add --scenario and --set."""
    parser.add_argument(
        "--scenario",
        default="peaceful",
        metavar="NAME|FILE",
        help="a scenario's name or a .toml file (default peaceful)",
    )
    parser.add_argument(
        "--set",
        dest="changes",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set any key of the scenario, such as fish.0.number=20 or nature.keen=0.3; may be "
        "given several times",
    )


def add_seed(parser: ArgumentParser) -> None:
    """Add --seed."""
    parser.add_argument(
        "--seed",
        type=number_reader(int, 0, 2**32 - 1),
        metavar="N",
        help="use this seed instead of the scenario's: other fishes, same sea",
    )


def add_fish(parser: ArgumentParser) -> None:
    """Add --fish."""
    parser.add_argument(
        "--fish",
        type=number_reader(int, 1, 100_000),
        metavar="N",
        help="total number of fishes, instead of the scenario's",
    )


def add_display(parser: ArgumentParser) -> None:
    """Add --display."""
    parser.add_argument(
        "--display",
        type=_display,
        default="mono",
        metavar="MODE",
        help="mono, or one of the stereo modes: stereo (shutter glasses, in a window), "
        "side-by-side, top-bottom, anaglyph, anaglyph-comfort, interlaced, checkerboard; or "
        "all round: panorama, dome, equirectangular (default mono)",
    )


def add_theatre(parser: ArgumentParser) -> None:
    """Add --theatre and --shrink."""
    parser.add_argument(
        "--theatre",
        metavar="NAME|FILE",
        help="show the windows, screens and projectors of a theatre, by name or a .toml file, "
        "instead of one window; --display sets how two eyes share each of them",
    )
    parser.add_argument(
        "--shrink",
        type=number_reader(int, 1, 64),
        metavar="N",
        help="divide the theatre's width and height in pixels by N, to try it out",
    )


def add_stereo(parser: ArgumentParser) -> None:
    """Add the options of the two eyes."""
    parser.add_argument("--swap-eyes", action="store_true", help="exchange left and right")
    parser.add_argument(
        "--eye-distance",
        type=number_reader(float, 0.0, 100.0),
        metavar="CM",
        help="distance between the eyes (default 6.4): a larger one deepens the sea and shrinks it",
    )
    parser.add_argument(
        "--screen-distance",
        type=number_reader(float, 20.0, 5000.0),
        metavar="CM",
        help="distance to the screen: nearer things stand out of it, others lie behind it "
        "(default 120)",
    )
    parser.add_argument(
        "--screen-width",
        type=number_reader(float, 5.0, 10000.0),
        metavar="CM",
        help="width of the real screen: on a wide one the eyes come closer together, so that "
        "viewers never have to turn theirs outwards",
    )
    parser.add_argument(
        "--comfort",
        type=number_reader(float, 0.1, 10.0),
        metavar="DEG",
        help="limit how far eyes turn between the screen and infinity: 1 tires few people; the "
        "eyes come closer together for it (default: no limit)",
    )


def add_surround(parser: ArgumentParser) -> None:
    """Add the options of panorama and dome."""
    parser.add_argument(
        "--panorama-angle",
        type=number_reader(float, 30.0, 359.0),
        metavar="DEG",
        help="angle of view of a panorama from left to right (default 160)",
    )
    parser.add_argument(
        "--dome-tilt",
        type=number_reader(float, 0.0, 90.0),
        metavar="DEG",
        help="tilt of a dome toward the front; 0 has the zenith in its middle (default 30)",
    )


def add_size(parser: ArgumentParser) -> None:
    """Add --size."""
    parser.add_argument(
        "--size",
        type=_size,
        metavar="WxH",
        help=f"pixels (default {SIZE[0]}x{SIZE[1]})",
    )


def add_quality(parser: ArgumentParser, default: str, *, automatic: bool = True) -> None:
    """Add --quality, with the choice auto if it is `automatic`."""
    auto = ", or auto, which holds --target-ms" if automatic else ""
    parser.add_argument(
        "--quality",
        type=_quality if automatic else _preset,
        default=default,
        metavar="Q",
        help=f"low, medium or high{auto} (default {default})",
    )


def add_target(parser: ArgumentParser) -> None:
    """Add --target-ms."""
    parser.add_argument(
        "--target-ms",
        type=number_reader(float, 1.0, 1000.0),
        metavar="MS",
        help="frame time that --quality auto holds (default 16.7 on a GPU, 50 without)",
    )


def add_drawing(parser: ArgumentParser) -> None:
    """Add the diagrams, --wireframe and --lights."""
    parser.add_argument(
        "--show",
        type=_diagrams,
        default=(),
        metavar="LIST",
        help="diagrams over the sea, separated by commas: scaffold, control-mesh, sensitivity, "
        "school, perception, frusta, axes, paths, bounds, indices",
    )
    parser.add_argument(
        "--wireframe", action="store_true", help="draw the edges of all triangles, not the faces"
    )
    parser.add_argument(
        "--lights",
        dest="changes",
        action="append_const",
        const="submarine.lights=true",
        default=[],
        help="start with the submarine's lights on",
    )


def add_follow(parser: Any) -> None:
    """Add --follow."""
    parser.add_argument(
        "--follow",
        metavar="FISH",
        help="look at a fish from behind: its number, its species, or SPECIES:NUMBER counted "
        "from 0",
    )


def add_gaze(parser: Any) -> None:
    """Add --gaze."""
    parser.add_argument(
        "--gaze",
        type=_gaze,
        metavar="PAN,TILT",
        help="degrees that its eyes look to the right and up from straight ahead (default 0,0; "
        "write --gaze=-30,10)",
    )


def add_see_brightness(parser: Any) -> None:
    """Add --see-brightness."""
    parser.add_argument(
        "--see-brightness",
        action="store_true",
        help="the fish whose eyes are shown reacts to the mean brightness of what it sees, instead "
        "of the sea's",
    )


def _size(text: str) -> tuple[int, int]:
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ArgumentTypeError(f"{text!r} is not a size such as 1280x720")
    size = int(width), int(height)
    if not all(MIN_SIZE <= pixels <= MAX_SIZE for pixels in size):
        raise ArgumentTypeError(
            f"{text!r} is out of range, expected {MIN_SIZE} to {MAX_SIZE} pixels a side"
        )
    return size


def _gaze(text: str) -> tuple[float, float]:
    try:
        pan, tilt = (float(part) for part in text.split(","))
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a gaze such as 30,-10") from None
    if not (abs(pan) <= 180.0 and abs(tilt) <= 90.0):
        raise ArgumentTypeError(
            f"{text!r} is out of range, expected -180 to 180 and -90 to 90 degrees"
        )
    return pan, tilt


def _display(text: str) -> str:
    from subsea.view.display_rigs import check_display

    return check_display(text)


def _quality(text: str) -> str:
    from subsea.render.output.quality import check_choice

    return check_choice(text)


def _preset(text: str) -> str:
    from subsea.render.output.quality import AUTO

    if _quality(text) == AUTO:
        raise UserError("a film has no frame time to hold: take --quality low, medium or high")
    return text


def _diagrams(text: str) -> tuple[str, ...]:
    from subsea.frame.diagrams import chosen_diagrams

    return chosen_diagrams(text)


def check_target(options: Namespace) -> None:
    """Refuse --target-ms without --quality auto."""
    from subsea.render.output.quality import AUTO

    if options.target_ms is not None and options.quality != AUTO:
        raise UserError(f"--target-ms needs --quality auto, not {options.quality}")


def check_display_without_window(display: str) -> None:
    """Refuse the display mode that needs a window."""
    from subsea.view.stereo import OTHER_STEREO, PAGED

    if display == PAGED:
        raise UserError(
            f"--display {PAGED} needs a window with a buffer for each eye; without a window take "
            f"{OTHER_STEREO}"
        )


def refuse(options: Namespace, names: Iterable[str], message: str) -> None:
    """Raise a UserError if one of these options is given; `{}` in `message` is its name."""
    for name in names:
        value = getattr(options, name, None)
        if value is not None and value is not False and value != ():
            raise UserError(message.format(f"--{name.replace('_', '-')}"))


def settle_size(options: Namespace) -> None:
    """Fill in the defaults of --size and --shrink; a theatre file defines its own sizes."""
    if options.theatre is not None:
        name = f"{options.command}: {{}} is defined by the --theatre file"
        refuse(options, SINGLE_WINDOW, name)
    options.size = options.size or SIZE
    options.shrink = options.shrink or 1


def optics(options: Namespace) -> tuple["Stereo", "Surround"]:
    """Group the options of :func:`add_stereo` and :func:`add_surround`."""
    from subsea.view.stereo import Stereo
    from subsea.view.surround import Surround

    stereo = {
        "separation_cm": options.eye_distance,
        "screen_cm": options.screen_distance,
        "screen_width_cm": options.screen_width,
        "swapped": options.swap_eyes,
        "comfort_deg": options.comfort,
    }
    surround = {"angle_deg": options.panorama_angle, "tilt_deg": options.dome_tilt}
    return Stereo(**_given(stereo)), Surround(**_given(surround))


def _given(options: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}
