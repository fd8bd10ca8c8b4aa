"""`subsea theatre`: check a theatre file, draw its room, or write a new one."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force
from subsea.base.errors import UserError
from subsea.stage.theatre.measures import KINDS, MEASURES

GROUP = "scenarios and theatres"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    kinds = "\n".join(f"  {name:<8}{words}" for name, words in KINDS.items())
    parser = add_command(
        commands,
        "theatre",
        "check a theatre file, or write a new one",
        "Lists windows, channels, screens, meshes and masks. Exit code 1 if a channel does not\n"
        "work. The keys of the file: docs/reference/theatre-file.md.\n\n"
        f"--new writes a file for your own room. Kinds:\n{kinds}",
        [
            "subsea theatre three-projectors",
            "subsea theatre my/theatre.toml",
            "subsea theatre dome.json --write dome.toml",
            "subsea theatre cave --picture room.png",
            "subsea theatre --new --out foyer.toml",
            "subsea theatre --new dome --projectors 6 --radius 400 --out dome6.toml",
            "subsea theatre dome6.toml --patterns patterns",
            "subsea theatre dome6.toml --calibrate photographs",
        ],
    )
    parser.add_argument(
        "name", metavar="NAME|FILE", nargs="?", help="name, .toml file or another program's file"
    )
    parser.add_argument(
        "--write", metavar="OUT.toml", type=Path, help="write it as a theatre file of our own"
    )
    parser.add_argument(
        "--picture", metavar="PNG", type=Path, help="draw room, screens, projectors and best seat"
    )
    parser.add_argument(
        "--new", metavar="KIND", nargs="?", const="", help="write a new theatre; no KIND: ask"
    )
    parser.add_argument(
        "--out", metavar="FILE", type=Path, help="file of the new or calibrated theatre"
    )
    for one in MEASURES:
        parser.add_argument(f"--{one.name}", metavar="N", type=one.reader, help=one.text)
    parser.add_argument(
        "--computers", action="store_true", help="one computer for each projector of a new theatre"
    )
    group = parser.add_argument_group(
        "calibrate with a camera", "by photographs of structured light: docs/how-to/calibrate.md"
    )
    group.add_argument(
        "--patterns",
        metavar="DIR",
        type=Path,
        help="write the structured light as pictures, and a points.toml to fill in",
    )
    group.add_argument(
        "--calibrate",
        metavar="PHOTOS",
        type=Path,
        help="measure the projectors by a folder of photographs, or one with a folder for each "
        "camera, and write NAME-calibrated.toml (needs the extra `calibrate`)",
    )
    group.add_argument(
        "--points",
        metavar="FILE",
        type=Path,
        help="reference points of a camera (default: points.toml beside its photographs)",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Describe or write a theatre; 1 if a part of it does not work."""
    given = {one.name: getattr(options, one.name) for one in MEASURES}
    if options.points is not None and options.calibrate is None:
        raise UserError("--points needs --calibrate too")
    if options.new is None:
        for name in ("computers", *given):
            if getattr(options, name) not in (None, False):
                raise UserError(f"--{name} needs --new too")
        if options.out is not None and options.calibrate is None:
            raise UserError("--out needs --new or --calibrate too")
        if options.name is None:
            raise UserError("theatre: expected a name or a file, or --new")
        if options.patterns is not None or options.calibrate is not None:
            return _calibrate(options)
        from subsea.stage.setup import describe

        code = describe(options.name, options.write, options.force)
        if options.picture is not None:
            from subsea.stage.plan import draw_room

            draw_room(options.name, options.picture, options.force)
        return code
    if options.name is not None:
        raise UserError(f"theatre: --new writes to --out FILE, drop {options.name!r}")
    if options.write is not None:
        raise UserError("theatre: --new writes to --out FILE, drop --write")
    if options.patterns is not None or options.calibrate is not None:
        raise UserError("theatre: --patterns and --calibrate go without --new")
    if options.out is None:
        raise UserError("theatre: --new needs --out FILE.toml")
    from subsea.stage.plan import NewTheatre, write_theatre

    return write_theatre(
        NewTheatre(
            options.new, given, options.out, options.picture, options.computers, options.force
        )
    )


def _calibrate(options: Namespace) -> int:
    """Write patterns, or measure a theatre by photographs of them."""
    for name in ("write", "picture"):
        if getattr(options, name) is not None:
            raise UserError(f"theatre: --patterns and --calibrate go without --{name}")
    from subsea.stage.calibration.calibrate import CalibrationOptions, calibrate, write_patterns

    if options.patterns is not None:
        write_patterns(options.name, options.patterns, options.force)
    if options.calibrate is not None:
        wanted = CalibrationOptions(options.calibrate, options.points, options.out, options.force)
        calibrate(options.name, wanted)
    return 0
