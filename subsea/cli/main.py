"""The command line: what may be asked, checked before anything heavy is loaded."""

import argparse
import gc
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subsea.core.command_line import answer, command, number, parse, program
from subsea.core.errors import UserError, unknown

if TYPE_CHECKING:
    from subsea.dive.options import DiveOptions
    from subsea.dive.settings import Settings

MAX_SIZE = 8192  # pixels; what a GPU of today can hold, at least for one eye
MIN_SIZE = 64
SIZE = 1280, 720  # unless told otherwise
MOTORS = ("playback", "dynamics")
STAGES_TO_LEAVE_OUT = ("culling", "lod")
STEREO = "swap_eyes", "eye_distance", "screen_distance", "screen_width", "comfort"
SURROUND = "panorama_angle", "dome_tilt"
# What a theatre's file says itself.
OF_ONE_WINDOW = "size", "fullscreen", "screen_distance", "screen_width", *SURROUND


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `subsea` with these arguments (default: the process's) and return its exit code.

    0 done, 1 a negative finding of `doctor` or `theatre`, 2 something the user can mend (one line
    on standard error), 130 interrupted.
    """
    # A start makes a million objects that stay: no need to look through them over and over.
    gc.set_threshold(100_000)
    return answer("subsea", lambda: _run(sys.argv[1:] if arguments is None else arguments))


def _run(arguments: Sequence[str]) -> int:
    parser, commands = parsers()
    if not arguments:
        parser.print_help()
        return 0
    options = parse(parser, commands, arguments)
    if getattr(options, "paper", False):
        for other in arguments[1:]:
            if other != "--paper":
                raise UserError(f"benchmark: --paper takes no other option, {other!r} was given")
    run: Callable[..., int] = options.run
    return run(**{k: v for k, v in vars(options).items() if k not in ("run", "command")})


class _Version(argparse.Action):
    """Looks the version up only when asked: that takes longer than all other parsing."""

    def __call__(self, parser: argparse.ArgumentParser, *unused: object) -> None:
        from importlib.metadata import version

        print(f"subsea {version('subsea')}")
        parser.exit()


def parsers() -> tuple[argparse.ArgumentParser, Any]:
    """The parser of `subsea` and its commands."""
    parser = program("subsea", "A submarine among artificial fishes.")
    parser.add_argument(
        "--version",
        action=_Version,
        nargs=0,
        default=argparse.SUPPRESS,
        help="show the version and exit",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for add in (
        _add_dive,
        _add_film,
        _add_theatre_command,
        _add_simulate,
        _add_study,
        _add_benchmark,
        _add_soak,
        _add_skin,
        _add_build,
        _add_doctor,
        _add_keys,
        _add_settings,
    ):
        add(commands)
    return parser, commands


def _add_dive(commands: Any) -> None:
    dive = command(
        commands,
        "dive",
        "pilot the submarine in a window",
        "Point where you want to look, hold the left button to go there, press the wheel or\n"
        "the space bar to stop. H shows every control, Esc opens the menu.",
        [
            "subsea dive",
            "subsea dive --fullscreen --seed 3",
            "subsea dive --display side-by-side --screen-width 120 --comfort 1",
            "subsea dive --theatre three-projectors --shrink 4",
        ],
    )
    _add_scenario(dive)
    _add_display(dive)
    _add_theatre(dive)
    dive.add_argument(
        "--node",
        metavar="NAME",
        help="which of a theatre's computers this is, when each shows its own windows: "
        "docs/cluster.md",
    )
    _add_stereo(dive)
    _add_surround(dive)
    _add_size(dive)
    _add_quality(dive, "auto")
    _add_target(dive)
    dive.add_argument(
        "--fullscreen",
        action=argparse.BooleanOptionalAction,
        help="fill the screen (F11 toggles)",
    )
    dive.add_argument(
        "--tour",
        metavar="NAME",
        help="one of the scenario's tours, directed, where its directions want the camera, or "
        "auto takes the submarine along until a hand moves, and again when nobody has steered for "
        "a while",
    )
    dive.add_argument(
        "--attract",
        type=number(float, 0, 1440),
        metavar="MIN",
        help="minutes without a hand until a tour begins by itself; 0: never",
    )
    dive.add_argument(
        "--kiosk",
        action="store_true",
        help="for exhibitions: full screen, and nothing by which a visitor could strand it; "
        "Ctrl+Shift+Q leaves",
    )
    _add_seed(dive)
    dive.add_argument(
        "--seconds", type=number(float, 0.1, 86400), metavar="S", help="end by itself after S"
    )
    _add_drawing(dive)
    _add_ride(dive)
    dive.add_argument(
        "--pace",
        type=_pace,
        metavar="RATE",
        help="seconds of the sea in a second: 0.25, 0.5, 1, 2 or 4; 0: it stands still",
    )
    dive.add_argument(
        "--settings",
        type=Path,
        metavar="FILE",
        help="instead of those in their usual place, which `subsea settings` tells",
    )
    # What is not given is as the settings say.
    dive.set_defaults(run=_dive, display=None, quality=None)


def _add_film(commands: Any) -> None:
    film = command(
        commands,
        "film",
        "film a tour, without a window",
        "OUT decides what is made: a film (.mp4), one picture (.png), or a folder of numbered\n"
        "pictures, which goes on where an interrupted one ended. Needs OpenGL, but no display.",
        [
            "subsea film dive.mp4",
            "subsea film reef.png --size 1920x1080 --seconds 8",
            "subsea film frames/ --seconds 2 --fps 30",
            "subsea film theatre.mp4 --theatre three-projectors",
            "subsea film springs.png --show scaffold,school --wireframe",
            "subsea film seen/ --eyes clownfish --size 320x240 --seconds 4",
        ],
    )
    film.add_argument("out", metavar="OUT", type=Path, help="FILE.mp4, FILE.png or a folder")
    _add_scenario(film)
    _add_display(film)
    _add_stereo(film)
    _add_surround(film)
    film.add_argument(
        "--seconds",
        type=number(float, 0.05, 3600),
        metavar="S",
        help="length of the film, a single picture is taken at its end (default 10, or to the end "
        "of a tour by name or of the directions)",
    )
    film.add_argument(
        "--tour",
        default="auto",
        metavar="NAME",
        help="one of the scenario's tours, directed, where its directions want the camera, or "
        "auto, which goes where something happens (default auto)",
    )
    film.add_argument(
        "--start",
        type=number(float, 0.0, 86400.0),
        default=0.0,
        metavar="S",
        help="seconds of the dive that pass before the film begins (default 0)",
    )
    film.add_argument(
        "--fps",
        type=number(float, 1, 240),
        default=30.0,
        metavar="F",
        help="pictures per second (default 30)",
    )
    _add_size(film)
    _add_quality(film, "high")
    _add_seed(film)
    _add_drawing(film)
    _add_follow(film)
    _add_eyes(film)
    _add_theatre(film)
    film.set_defaults(run=_film)


def _add_theatre_command(commands: Any) -> None:
    theatre = command(
        commands,
        "theatre",
        "tell what a theatre file has, and what of it does not work",
        "Windows, channels, screens, meshes and masks, without opening a window. Exit code 1 if\n"
        "a channel does not work. docs/theatre.md says how to write one.",
        ["subsea theatre three-projectors", "subsea theatre my/theatre.toml"],
    )
    theatre.add_argument("name", metavar="NAME|FILE", help="a theatre's name or a .toml file")
    theatre.set_defaults(run=_theatre)


def _add_simulate(commands: Any) -> None:
    simulate = command(
        commands,
        "simulate",
        "record what every fish does, without pictures",
        "Writes an HDF5 file for those who study the fishes. Needs no OpenGL. An interrupted\n"
        "run leaves a valid file with the ticks so far.",
        [
            "subsea simulate --ticks 1000 --out run.h5",
            "subsea simulate --ticks 9000 --out run.h5 --fish 400 --seed 7",
            "subsea simulate --ticks 900 --out run.h5 --set nature.keen=0.4 --set fish.0.hunger=1",
        ],
    )
    simulate.add_argument(
        "--ticks",
        type=number(int, 1, 100_000_000),
        required=True,
        metavar="N",
        help="length of the run; a tick is 33 ms",
    )
    simulate.add_argument("--out", type=Path, required=True, metavar="FILE.h5")
    _add_scenario(simulate)
    _add_fish(simulate)
    _add_seed(simulate)
    simulate.set_defaults(run=_simulate)


def _add_study(commands: Any) -> None:
    study = command(
        commands,
        "study",
        "measure what a record shows",
        "Prints a table: collisions, time budgets, schools, escapes, captures, matings, meals.\n"
        "docs/records.md defines every measure. Plots need the extra `plot`.",
        [
            "subsea study run.h5",
            "subsea study run.h5 --out plots --json run.json",
        ],
    )
    study.add_argument("record", metavar="RECORD.h5", type=Path, help="from `subsea simulate`")
    study.add_argument("--out", type=Path, metavar="DIR", help="draw plots (PNG) into this folder")
    study.add_argument(
        "--json", type=Path, dest="json_file", metavar="FILE", help="write the measures there too"
    )
    study.set_defaults(run=_study)


def _add_benchmark(commands: Any) -> None:
    benchmark = command(
        commands,
        "benchmark",
        "measure how long every stage of a frame takes",
        "One tick of the world and one picture a frame, without a window; docs/diving.md gives\n"
        "the formula of every figure. --paper measures what the 1999 paper measured.",
        [
            "subsea benchmark --frames 120 --json report.json",
            "subsea benchmark --fish 60,1000,10000 --tour reef --compare report.json",
            "subsea benchmark --fish 1000 --without culling,lod",
            "subsea benchmark --fish 200 --motor dynamics",
            "subsea benchmark --paper",
        ],
    )
    _add_scenario(benchmark)
    benchmark.add_argument(
        "--fish",
        type=_rungs,
        metavar="N,…",
        help="number of fishes in all, instead of the scenario's; several, separated by commas, "
        "are measured one after another",
    )
    benchmark.add_argument(
        "--tour",
        default="auto",
        metavar="NAME",
        help="one of the scenario's tours, whatever the fishes do, or directed (default auto, "
        "which goes where something happens)",
    )
    benchmark.add_argument(
        "--frames",
        type=number(int, 1, 100_000),
        default=120,
        metavar="N",
        help="frames that count, after the warm-up (default 120)",
    )
    _add_theatre(benchmark)
    _add_size(benchmark)
    _add_quality(benchmark, "low")
    _add_target(benchmark)
    _add_display(benchmark)
    _add_seed(benchmark)
    benchmark.add_argument(
        "--without",
        type=_left_out,
        default=frozenset(),
        metavar="LIST",
        help=f"leave out, separated by commas: {', '.join(STAGES_TO_LEAVE_OUT)}",
    )
    benchmark.add_argument(
        "--motor",
        type=_motor,
        default="playback",
        metavar="MOTOR",
        help="playback, or dynamics: every fish with muscles is simulated (default playback)",
    )
    benchmark.add_argument(
        "--json", type=Path, dest="out", metavar="FILE", help="write the report there too"
    )
    benchmark.add_argument(
        "--compare",
        type=Path,
        dest="against",
        metavar="FILE",
        help="how many times faster than in an older report of --json",
    )
    benchmark.add_argument(
        "--csv", type=Path, metavar="FILE", help="write what every frame took there"
    )
    benchmark.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="draw what every frame took there, as PNG (needs matplotlib: subsea[plot])",
    )
    benchmark.add_argument(
        "--paper", action="store_true", help="tables 3 and 4 of the 1999 paper for this machine"
    )
    benchmark.set_defaults(run=_benchmark)


def _add_soak(commands: Any) -> None:
    soak = command(
        commands,
        "soak",
        "dive for hours with hands at random, and watch for what must never happen",
        "Steers, takes fishes' reins, changes current and lights, lets time go back, and draws in\n"
        "one display mode and theatre after another. Watches for numbers that are none, fishes\n"
        "out of the sea, in stone or stuck, a past that does not come again equally, and memory\n"
        "that grows. Exit code 1 if anything was found.",
        [
            "subsea soak --minutes 60",
            "subsea soak --scenario open-ocean --minutes 5 --json soak.json",
            "subsea soak --scenario open-ocean --minutes 5 --compare soak.json",
        ],
    )
    _add_scenario(soak)
    _add_fish(soak)
    _add_seed(soak)
    soak.add_argument(
        "--minutes",
        type=number(float, 0.01, 1440),
        default=10.0,
        metavar="M",
        help="of the sea's own time (default 10)",
    )
    soak.add_argument(
        "--draw",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="make a picture every second of the sea (--no-draw: no OpenGL)",
    )
    soak.add_argument("--json", type=Path, dest="out", metavar="FILE", help="write a report there")
    soak.add_argument(
        "--compare",
        type=Path,
        dest="against",
        metavar="FILE",
        help="the report of the same soak, the checksums of which must come again",
    )
    soak.set_defaults(run=_soak)


def _add_skin(commands: Any) -> None:
    skin = command(
        commands,
        "skin",
        "dress a species from a photograph",
        "A window in which meshes are dragged over the fish until they hold its outline; --auto\n"
        "does all without one. What lies under them is the skin that the species wears: a picture\n"
        "beside its file, which skin.sheet names. docs/skin.md tells how, and what makes a good\n"
        "photograph. Needs the extra `skin`.",
        [
            "subsea skin guppy.jpg",
            "subsea skin guppy.jpg --species my_guppy --mesh guppy.json",
            "subsea skin guppy.jpg --species my_guppy --auto",
            "subsea skin guppy.jpg --species my_guppy --auto --flip",
            "subsea skin guppy.jpg --species my_guppy --auto --mesh guppy.json",
            "subsea skin clown.png --species clownfish --auto --out sheet.png",
        ],
    )
    skin.add_argument("photo", metavar="PHOTO", type=Path, help="a fish from its side: JPEG, PNG …")
    skin.add_argument(
        "--species", metavar="NAME", help="who is to wear it (in the window default clownfish)"
    )
    skin.add_argument("--auto", action="store_true", help="without a window")
    skin.add_argument(
        "--out", type=Path, metavar="FILE.png", help="write the sheet there and change no species"
    )
    skin.add_argument("--flip", action="store_true", help="it heads the other way than is found")
    skin.add_argument(
        "--mesh",
        type=Path,
        metavar="FILE.json",
        help="meshes to use instead of looking for the fish; written if it is not there, in the "
        "window by Save",
    )
    skin.set_defaults(run=_skin)


def _add_build(commands: Any) -> None:
    build = command(
        commands,
        "build",
        "build a fish in a window: outline, scaffold, muscles",
        "A species begins as a copy of another one and is saved among your own. Its points are\n"
        "dragged in a side view and a top view, it swims beside them by its own muscles, and\n"
        "checks say what it lacks. Learn and Record make it swim in the sea: docs/builder.md.",
        ["subsea build", "subsea build clownfish", "subsea build my_fish --over fish.jpg"],
    )
    build.add_argument(
        "name", metavar="SPECIES", nargs="?", help="species, or the path of its .toml file"
    )
    build.add_argument(
        "--in-place",
        action="store_true",
        help="save a species that comes with the program into its own file, not under a new name",
    )
    build.add_argument(
        "--over",
        type=Path,
        metavar="PHOTO",
        help="a photograph from the side, behind the side view, to draw over",
    )
    build.set_defaults(run=_build)


def _add_doctor(commands: Any) -> None:
    doctor = command(
        commands,
        "doctor",
        "tell what this machine can do, and what to install",
        "Exit code 0 if a dive in a window is possible here, 1 if not.",
        ["subsea doctor"],
    )
    doctor.set_defaults(run=_doctor)


def _add_keys(commands: Any) -> None:
    keys = command(
        commands,
        "keys",
        "make keys by which the computers of a theatre know each other",
        "Writes NAME.key, for everybody, and NAME.key_secret, for that computer alone, into a\n"
        "folder. The names are those of the theatre's nodes; docs/cluster.md says the rest.",
        ["subsea keys keys/ middle left right"],
    )
    keys.add_argument("folder", metavar="DIR", type=Path, help="where they go")
    keys.add_argument("names", metavar="NAME", nargs="+", help="a node of the theatre")
    keys.set_defaults(run=_keys)


def _add_settings(commands: Any) -> None:
    settings = command(
        commands,
        "settings",
        "tell where the settings of a dive are, or write them there",
        "Keys, mouse, gamepad, comfort and the picture, in one commented file; docs/settings.md\n"
        "has all of it.",
        ["subsea settings", "subsea settings --write"],
    )
    settings.add_argument(
        "--write", action="store_true", help="write a file with all the defaults, if none is there"
    )
    settings.set_defaults(run=_settings)


def _add_scenario(parser: argparse.ArgumentParser) -> None:
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
        help="another value of any key of the scenario, such as fish.0.number=20 or "
        "nature.keen=0.3; may be given several times",
    )


def _add_display(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--display",
        type=_display,
        default="mono",
        metavar="MODE",
        help="mono, or one of the stereo modes: stereo (shutter glasses, in a window), "
        "side-by-side, top-bottom, anaglyph, anaglyph-comfort, interlaced, checkerboard; or "
        "all round: panorama, dome, equirectangular (default mono)",
    )


def _add_theatre(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--theatre",
        metavar="NAME|FILE",
        help="the windows, screens and projectors of a theatre, by name or a .toml file, instead "
        "of one window; --display says how two eyes share each of them",
    )
    parser.add_argument(
        "--shrink",
        type=number(int, 1, 64),
        metavar="N",
        help="show the theatre with N times fewer pixels a side, to try it out",
    )


def _add_stereo(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--swap-eyes", action="store_true", help="left and right exchanged")
    parser.add_argument(
        "--eye-distance",
        type=number(float, 0.0, 100.0),
        metavar="CM",
        help="between the two eyes (default 6.4): more deepens the sea and shrinks it",
    )
    parser.add_argument(
        "--screen-distance",
        type=number(float, 20.0, 5000.0),
        metavar="CM",
        help="what is nearer stands out of the screen, the rest lies behind it (default 120)",
    )
    parser.add_argument(
        "--screen-width",
        type=number(float, 5.0, 10000.0),
        metavar="CM",
        help="of the real screen: on a wide one the eyes come nearer together, so that nobody's "
        "have to turn outwards",
    )
    parser.add_argument(
        "--comfort",
        type=number(float, 0.1, 10.0),
        metavar="DEG",
        help="most that eyes turn between the screen and infinity: 1 tires few people; the eyes "
        "come nearer together for it (default: no limit)",
    )


def _add_surround(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--panorama-angle",
        type=number(float, 30.0, 359.0),
        metavar="DEG",
        help="what a panorama shows from left to right (default 160)",
    )
    parser.add_argument(
        "--dome-tilt",
        type=number(float, 0.0, 90.0),
        metavar="DEG",
        help="of a dome toward the front; 0 has the zenith in its middle (default 30)",
    )


def _add_size(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--size",
        type=_size,
        metavar="WxH",
        help=f"pixels (default {SIZE[0]}x{SIZE[1]})",
    )


def _add_follow(parser: Any) -> None:
    parser.add_argument(
        "--follow",
        metavar="FISH",
        help="look at it from behind: its number, its species, or SPECIES:NUMBER counted from 0",
    )


def _add_ride(parser: argparse.ArgumentParser) -> None:
    fish = parser.add_argument_group("on a fish", "as keys do it in a dive: docs/fish-view.md")
    _add_follow(fish)
    fish.add_argument("--eyes", metavar="FISH", help="look through its eyes instead")
    _add_gaze(fish)
    fish.add_argument(
        "--look",
        choices=("colours", "identity", "range"),
        help="what the pictures of its eyes show",
    )
    fish.add_argument("--reins", action="store_true", help="steer it")
    _add_see_brightness(fish)


def _add_eyes(parser: argparse.ArgumentParser) -> None:
    fish = parser.add_argument_group(
        "what a fish sees",
        "labelled frames in the folder OUT; docs/fish-view.md tells how to use them",
    )
    fish.add_argument(
        "--eyes",
        metavar="FISH",
        help="its number, its species, or SPECIES:NUMBER counted from 0: both its eyes' pictures, "
        "identity and depth maps, and camera.json",
    )
    _add_gaze(fish)
    fish.add_argument(
        "--field",
        type=number(float, 20.0, 150.0),
        default=None,
        metavar="DEG",
        help="what a retina shows from left to right (default 90)",
    )
    _add_see_brightness(fish)


def _add_gaze(parser: Any) -> None:
    parser.add_argument(
        "--gaze",
        type=_gaze,
        default=None,
        metavar="PAN,TILT",
        help="degrees that its eyes look to the right and up from straight ahead (default 0,0; "
        "write --gaze=-30,10)",
    )


def _add_see_brightness(parser: Any) -> None:
    parser.add_argument(
        "--see-brightness",
        action="store_true",
        help="the fish whose eyes are shown goes by the mean brightness of what it sees, instead "
        "of the sea's",
    )


def _add_quality(parser: argparse.ArgumentParser, default: str) -> None:
    auto = "" if parser.prog.endswith("film") else ", or auto, which holds --target-ms"
    parser.add_argument(
        "--quality",
        type=_quality if auto else _preset,
        default=default,
        metavar="Q",
        help=f"low, medium or high{auto} (default {default})",
    )


def _add_target(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--target-ms",
        type=number(float, 1.0, 1000.0),
        metavar="MS",
        help="time of a frame that --quality auto holds (default 16.7 on a GPU, 50 without)",
    )


def _add_drawing(parser: argparse.ArgumentParser) -> None:
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
        help="with the submarine's lights on from the start",
    )


def _add_seed(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seed",
        type=number(int, 0, 2**32 - 1),
        metavar="N",
        help="another seed than the scenario's: other fishes, same sea",
    )


def _add_fish(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--fish",
        type=number(int, 1, 100_000),
        metavar="N",
        help="number of fishes in all, instead of the scenario's",
    )


def _rungs(text: str) -> tuple[int, ...]:
    one = number(int, 1, 100_000)
    rungs = tuple(int(one(part.strip())) for part in text.split(","))
    if len(set(rungs)) < len(rungs):
        raise argparse.ArgumentTypeError(f"{text!r}: expected every number once")
    return rungs


def _size(text: str) -> tuple[int, int]:
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 1280x720")
    size = int(width), int(height)
    if not all(MIN_SIZE <= pixels <= MAX_SIZE for pixels in size):
        raise argparse.ArgumentTypeError(
            f"{text!r} is out of range, expected {MIN_SIZE} to {MAX_SIZE} pixels a side"
        )
    return size


def _pace(text: str) -> float:
    if text not in ("0", "0.25", "0.5", "1", "2", "4"):
        raise argparse.ArgumentTypeError(f"{text!r}: expected 0, 0.25, 0.5, 1, 2 or 4")
    return float(text)


def _gaze(text: str) -> tuple[float, float]:
    try:
        pan, tilt = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a gaze such as 30,-10") from None
    if not (abs(pan) <= 180.0 and abs(tilt) <= 90.0):
        raise argparse.ArgumentTypeError(
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
        raise UserError("a film has all the time that it takes: --quality low, medium or high")
    return text


def _check_target(quality: str, target_ms: float | None) -> None:
    from subsea.render.output.quality import AUTO

    if target_ms is not None and quality != AUTO:
        raise UserError(f"--target-ms is what --quality auto holds, and this is {quality}")


def _diagrams(text: str) -> tuple[str, ...]:
    from subsea.frame.diagrams import chosen_diagrams

    return chosen_diagrams(text)


def _motor(text: str) -> str:
    if text not in MOTORS:
        raise unknown("motor", text, list(MOTORS))
    return text


def _left_out(text: str) -> frozenset[str]:
    words = [word.strip() for word in text.split(",") if word.strip()]
    for word in words:
        if word not in STAGES_TO_LEAVE_OUT:
            raise unknown("stage to leave out", word, list(STAGES_TO_LEAVE_OUT))
    return frozenset(words)


# Each command loads its own modules, so that a wrong option answers at once and `simulate`
# runs on machines without OpenGL.


def _dive(settings: Path | None, **given: Any) -> int:
    # Read when numpy is loaded: its threads, one a core, would wait for work by turning in circles.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from msgspec.structs import replace

    from subsea.core.console import say
    from subsea.core.resources import named_or_file
    from subsea.dive.settings import read_settings, settings_path, usual_settings

    told: list[str] = []
    chosen = usual_settings(told.append) if settings is None else read_settings(settings)
    for line in told:
        say(line)
    notes = [line.replace(f"{settings_path().parent}/", "") for line in told]
    given = _with_settings(given, chosen)
    if given["attract"] is not None:
        chosen = replace(chosen, attract=replace(chosen.attract, after_min=given["attract"]))
    if given["kiosk"]:
        from subsea.ui.kiosk import locked

        chosen, given["fullscreen"] = locked(chosen), given["theatre"] is None
    options = _dive_options(given, chosen)
    with ExitStack() as undo:
        opening = None
        scenario = named_or_file(options.scenario, "assets/scenarios", ".toml", "scenario")
        # A misspelt name is told before a window flashes up.
        if scenario.is_file() and options.theatre is None:
            from subsea.ui.open_windows import opened

            display = options.display
            opening = opened(display.mode, display.size, display.fullscreen, chosen)
            undo.callback(opening.close)
        fresh = "subsea.ui.dive" not in sys.modules
        gc.disable()
        from subsea.ui.dive import dive  # takes longer to load than all before

        if fresh:  # what modules are made of stays: no need to look through it ever again
            gc.freeze()
        gc.enable()
        return dive(options, opening, notes)


def _dive_options(given: dict[str, Any], settings: "Settings") -> "DiveOptions":
    """The options of a dive in groups. What does not go together is a UserError."""
    from subsea.dive.options import DisplayOptions, DiveOptions, StartOptions, TheatreOptions

    _check_target(given["quality"], given["target_ms"])
    if given["follow"] and given["eyes"]:
        raise UserError("dive: --follow looks from behind, --eyes from within: expected one")
    if not (given["follow"] or given["eyes"]):
        _refuse(given, ("gaze", "look", "reins"), "dive: {} needs --eyes FISH or --follow FISH")
    given = _with_optics(_with_sizes("dive", given))
    theatre = None
    if given["theatre"] is not None:
        theatre = TheatreOptions(given["theatre"], given["shrink"], given["node"])
    elif given["shrink"] != 1:
        raise UserError("--shrink needs --theatre; give a smaller --size instead")
    elif given["node"] is not None:
        raise UserError("--node needs --theatre too")
    same = "scenario", "changes", "seed", "seconds", "tour", "kiosk", "see_brightness"
    shown = "size", "fullscreen", "stereo", "surround", "quality", "target_ms", "wireframe"
    return DiveOptions(
        **{name: given[name] for name in same},
        display=DisplayOptions(
            mode=given["display"], diagrams=given["show"], **{name: given[name] for name in shown}
        ),
        theatre=theatre,
        start=StartOptions(
            given["follow"], given["eyes"], given["gaze"], given["look"], given["reins"],
            given["pace"],
        ),
        settings=settings,
    )  # fmt: skip


def _with_settings(options: dict[str, Any], settings: "Settings") -> dict[str, Any]:
    """The options of a dive, those that are not given as the settings say."""
    said = settings.display
    usual: dict[str, Any] = {"quality": said.quality, "display": "mono", "fullscreen": False}
    if options["theatre"] is None:  # which says itself what its windows are
        usual |= {"display": said.mode, "size": said.size, "fullscreen": said.fullscreen}
    return options | {name: value for name, value in usual.items() if options[name] is None}


def _film(**options: Any) -> int:
    own = {key: options.pop(key) for key in ("eyes", "gaze", "field", "see_brightness")}
    if own["eyes"] is not None:
        return _film_eyes(own, options)
    for key, value in own.items():
        if value:
            raise UserError(f"film: --{key.replace('_', '-')} needs --eyes FISH")
    from subsea.media.film import film

    _no_pages(options["display"])
    return film(**_with_optics(_with_sizes("film", options)))


def _film_eyes(own: dict[str, Any], options: dict[str, Any]) -> int:
    from subsea.media.eye_frames import film_eyes
    from subsea.view.retina import FIELD_DEG, Gaze

    used = (
        "out", "scenario", "changes", "seconds", "start", "fps", "size", "quality", "seed", "tour",
    )  # fmt: skip
    other = ("theatre", "shrink", *STEREO, *SURROUND)
    if options["display"] != "mono":
        raise UserError(
            f"film: --eyes has a picture for each eye, not --display {options['display']}"
        )
    _refuse(options, other, "film: --eyes has a picture for each eye, not {}")
    drawing = ("show", "wireframe", "follow")
    _refuse(options, drawing, "film: --eyes shows what a fish sees, {} shows more")
    options = _with_sizes("film", options)
    return film_eyes(
        eyes=own["eyes"],
        gaze=Gaze(*(own["gaze"] or ())),
        field_deg=own["field"] or FIELD_DEG,
        see_brightness=own["see_brightness"],
        **{key: options[key] for key in used},
    )


def _refuse(options: dict[str, Any], names: Sequence[str], fault: str) -> None:
    """A UserError if one of these options is given, which would have no effect; `{}` is which."""
    for name in names:
        if (value := options.get(name)) is not None and value is not False and value != ():
            raise UserError(fault.format(f"--{name.replace('_', '-')}"))


def _with_sizes(name: str, options: dict[str, Any]) -> dict[str, Any]:
    """The options of the command `name` with its sizes, which are a theatre's own if it is one."""
    if options["theatre"] is not None:
        _refuse(options, OF_ONE_WINDOW, f"{name}: the --theatre file says itself what {{}} says")
    return options | {"size": options["size"] or SIZE, "shrink": options["shrink"] or 1}


def _with_optics(options: dict[str, Any]) -> dict[str, Any]:
    """The options with those of the eyes, and of what lies round them, put together."""
    from subsea.view.stereo import Stereo
    from subsea.view.surround import Surround

    given = {
        "separation_cm": options.pop("eye_distance"),
        "screen_cm": options.pop("screen_distance"),
        "screen_width_cm": options.pop("screen_width"),
        "swapped": options.pop("swap_eyes"),
        "comfort_deg": options.pop("comfort"),
    }
    stereo = Stereo(**{name: value for name, value in given.items() if value is not None})
    wide = {
        "angle_deg": options.pop("panorama_angle"),
        "tilt_deg": options.pop("dome_tilt"),
    }
    surround = Surround(**{name: value for name, value in wide.items() if value is not None})
    return options | {"stereo": stereo, "surround": surround}


def _no_pages(display: str) -> None:
    from subsea.view.stereo import OTHER_STEREO, PAGED

    if display == PAGED:
        raise UserError(
            f"--display {PAGED} needs a window with a buffer for each eye; without a window take "
            f"{OTHER_STEREO}"
        )


def _simulate(**options: Any) -> int:
    from subsea.study.simulate import simulate

    return simulate(**options)


def _study(**options: Any) -> int:
    from subsea.study.report import study

    return study(**options)


def _benchmark(paper: bool, **options: Any) -> int:
    if paper:
        from subsea.profiling.paper_tables import paper_tables

        return paper_tables()
    from subsea.profiling.benchmark import benchmark

    _no_pages(options["display"])
    _check_target(options["quality"], options["target_ms"])
    return benchmark(**_with_sizes("benchmark", options))


def _soak(**options: Any) -> int:
    from subsea.profiling.soak import soak

    return soak(**options)


def _theatre(name: str) -> int:
    from subsea.dive.theatre_setup import describe

    return describe(name)


def _skin(
    photo: Path, species: str | None, auto: bool, out: Path | None, flip: bool, mesh: Path | None
) -> int:
    if auto and species is None:
        raise UserError("skin: --auto needs --species NAME")
    try:
        import cv2  # noqa: F401
    except ImportError as fault:
        raise UserError("skin needs OpenCV: install subsea[skin]") from fault
    if not auto:
        from subsea.ui.skin_editor.window import dress_by_hand

        return dress_by_hand(photo, species, out, flip, mesh)
    from subsea.fish.photo.dress import dress

    assert species
    return dress(photo, species, out, flip, mesh)


def _build(name: str | None, in_place: bool, over: Path | None) -> int:
    from subsea.ui.fish_builder.window import build

    return build(name, in_place, over)


def _doctor() -> int:
    from subsea.cli.doctor import doctor

    return doctor()


def _settings(write: bool) -> int:
    from subsea.dive.settings import show_settings

    return show_settings(write)


def _keys(folder: Path, names: list[str]) -> int:
    from subsea.dive.cluster.keys import write_keys

    for path in write_keys(folder, names):
        print(path)
    return 0
