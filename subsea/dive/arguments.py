"""Options that several commands share: their parsers and the checks between them."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Iterable
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from subsea.base.command_line import number_reader
from subsea.base.errors import UserError

if TYPE_CHECKING:
    from subsea.view.stereo import Stereo
    from subsea.view.surround import Surround

MAX_SIZE = 8192  # pixels; the largest texture of common GPUs
MIN_SIZE = 64
SIZE = 1280, 720  # default
SCENARIO = "scenario", "set"
STEREO = "swap-eyes", "eye-distance", "screen-distance", "screen-width", "comfort"
SURROUND = "panorama-angle", "dome-tilt"
DRAWING = "show", "wireframe", "lights"
# Defined by a theatre file if there is one.
SINGLE_WINDOW = "size", "fullscreen", "screen-distance", "screen-width", *SURROUND


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
    from subsea.rendering.output.quality import check_choice

    return check_choice(text)


def _preset(text: str) -> str:
    from subsea.rendering.output.quality import AUTO

    if _quality(text) == AUTO:
        raise UserError(
            "a film has no frame time to hold: take --quality low, medium, high or ultra"
        )
    return text


def _diagrams(text: str) -> tuple[str, ...]:
    from subsea.frame.diagrams import chosen_diagrams

    return chosen_diagrams(text)


OPTIONS: dict[str, dict[str, Any]] = {
    "scenario": {
        "default": "peaceful",
        "metavar": "NAME|FILE",
        "help": "name or .toml file (default peaceful)",
    },
    "set": {
        "dest": "changes",
        "action": "append",
        "default": [],
        "metavar": "KEY=VALUE",
        "help": "set a key of the scenario, such as fish.0.number=20",
    },
    "seed": {
        "type": number_reader(int, 0, 2**32 - 1),
        "metavar": "N",
        "help": "seed of the fishes (default: the scenario's)",
    },
    "fish": {
        "type": number_reader(int, 1, 100_000),
        "metavar": "N",
        "help": "total number of fishes (default: the scenario's)",
    },
    "tour": {
        "default": "auto",
        "metavar": "NAME",
        "help": "tour of the scenario, directed (the camera of its directions) or auto: where "
        "something happens (default auto)",
    },
    "display": {
        "type": _display,
        "default": "mono",
        "metavar": "MODE",
        "help": "mono (default), stereo (shutter glasses, only in a window), side-by-side, "
        "top-bottom, anaglyph, anaglyph-comfort, interlaced, checkerboard, panorama, dome, "
        "equirectangular or headset (only in a dive)",
    },
    "theatre": {
        "metavar": "NAME|FILE",
        "help": "show the windows of a theatre; --display selects mono or stereo in each",
    },
    "shrink": {
        "type": number_reader(int, 1, 64),
        "metavar": "N",
        "help": "divide width and height of the theatre's windows by N, for a test",
    },
    "swap-eyes": {"action": "store_true", "help": "exchange left and right"},
    "eye-distance": {
        "type": number_reader(float, 0.0, 100.0),
        "metavar": "CM",
        "help": "distance between the eyes (default 6.4); more gives more depth",
    },
    "screen-distance": {
        "type": number_reader(float, 20.0, 5000.0),
        "metavar": "CM",
        "help": "distance to the screen (default 120); nearer objects appear in front of it",
    },
    "screen-width": {
        "type": number_reader(float, 5.0, 10000.0),
        "metavar": "CM",
        "help": "width of the real screen; limits the eye distance so that no eye turns outwards",
    },
    "comfort": {
        "type": number_reader(float, 0.1, 10.0),
        "metavar": "DEG",
        "help": "limit of parallax between screen and infinity, by a smaller eye distance; 1 suits "
        "most viewers (default: no limit)",
    },
    "panorama-angle": {
        "type": number_reader(float, 30.0, 359.0),
        "metavar": "DEG",
        "help": "horizontal angle of a panorama (default 160)",
    },
    "dome-tilt": {
        "type": number_reader(float, 0.0, 90.0),
        "metavar": "DEG",
        "help": "forward tilt of a dome (default 30); 0: zenith in the middle",
    },
    "start": {
        "type": number_reader(float, 0.0, 86400.0),
        "default": 0.0,
        "metavar": "S",
        "help": "seconds of the dive to skip (default 0)",
    },
    "fps": {
        "type": number_reader(float, 1, 240),
        "default": 30.0,
        "metavar": "F",
        "help": "pictures per second (default 30)",
    },
    "size": {"type": _size, "metavar": "WxH", "help": f"pixels (default {SIZE[0]}x{SIZE[1]})"},
    "target-ms": {
        "type": number_reader(float, 1.0, 1000.0),
        "metavar": "MS",
        "help": "frame time for --quality auto (default 16.7 on a GPU, 50 without)",
    },
    "show": {
        "type": _diagrams,
        "default": (),
        "metavar": "LIST",
        "help": "diagrams, separated by commas: scaffold, control-mesh, sensitivity, "
        "school, perception, frusta, axes, paths, bounds, indices",
    },
    "wireframe": {
        "action": "store_true",
        "help": "draw only the edges of triangles",
    },
    "lights": {
        "dest": "changes",
        "action": "append_const",
        "const": "submarine.lights=true",
        "default": [],
        "help": "switch the submarine's lights on",
    },
    "follow": {
        "metavar": "FISH",
        "help": "follow a fish: number, species or SPECIES:NUMBER, counted from 0",
    },
    "gaze": {
        "type": _gaze,
        "metavar": "PAN,TILT",
        "help": "direction of its eyes, degrees right and up (default 0,0); write --gaze=-30,10",
    },
    "see-brightness": {
        "action": "store_true",
        "help": "the fish of --eyes reacts to the mean brightness of what it sees, not of the sea",
    },
}
"""Declarations of shared options, for :func:`add`."""


def add(parser: Any, *names: str) -> None:
    """Add options of `OPTIONS`, in this order."""
    for name in names:
        parser.add_argument(f"--{name}", **OPTIONS[name])


def add_quality(parser: ArgumentParser, default: str, *, automatic: bool = True) -> None:
    """Add --quality, with the choice auto if it is `automatic`."""
    auto = ", or auto (holds --target-ms)" if automatic else ""
    parser.add_argument(
        "--quality",
        type=_quality if automatic else _preset,
        default=default,
        metavar="Q",
        help=f"low, medium, high or ultra{auto} (default {default})",
    )


def check_target(options: Namespace) -> None:
    """Refuse --target-ms without --quality auto."""
    from subsea.rendering.output.quality import AUTO

    if options.target_ms is not None and options.quality != AUTO:
        raise UserError(f"--target-ms needs --quality auto, not {options.quality}")


def check_display_without_window(display: str) -> None:
    """Refuse the display mode that needs a window."""
    from subsea.view.display_rigs import HEADSET
    from subsea.view.stereo import OTHER_STEREO, PAGED

    if display == HEADSET:
        raise UserError(f"--display {HEADSET} is for a dive; for two eyes take {OTHER_STEREO}")
    if display == PAGED:
        raise UserError(
            f"--display {PAGED} needs a window with a buffer for each eye; without a window take "
            f"{OTHER_STEREO}"
        )


def refuse(options: Namespace, names: Iterable[str], message: str) -> None:
    """Raise a UserError if one of these options is given; `{}` in `message` is its name."""
    for name in names:
        value = getattr(options, name.replace("-", "_"), None)
        if value is not None and value is not False and value != ():
            raise UserError(message.format(f"--{name}"))


def settle_size(options: Namespace) -> None:
    """Fill in the defaults of --size and --shrink; a theatre file defines its own sizes."""
    if options.theatre is not None:
        name = f"{options.command}: {{}} is defined by the --theatre file"
        refuse(options, SINGLE_WINDOW, name)
    options.size = options.size or SIZE
    options.shrink = options.shrink or 1


def fields_of(kind: Any, options: Namespace) -> dict[str, Any]:
    """The options that are fields of a dataclass, by name."""
    names = [field.name for field in fields(kind) if hasattr(options, field.name)]
    return {name: getattr(options, name) for name in names}


def optics(options: Namespace) -> tuple["Stereo", "Surround"]:
    """Group the options `STEREO` and `SURROUND`."""
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
    given = [
        {name: value for name, value in group.items() if value is not None}
        for group in (stereo, surround)
    ]
    return Stereo(**given[0]), Surround(**given[1])
