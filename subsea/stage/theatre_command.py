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
    parser.add_argument("--out", metavar="FILE", type=Path, help="file of the new theatre")
    for one in MEASURES:
        parser.add_argument(f"--{one.name}", metavar="N", type=one.reader, help=one.text)
    parser.add_argument(
        "--computers", action="store_true", help="one computer for each projector of a new theatre"
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Describe or write a theatre; 1 if a part of it does not work."""
    given = {one.name: getattr(options, one.name) for one in MEASURES}
    if options.new is None:
        for name in ("out", "computers", *given):
            if getattr(options, name) not in (None, False):
                raise UserError(f"--{name} needs --new too")
        if options.name is None:
            raise UserError("theatre: expected a name or a file, or --new")
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
    if options.out is None:
        raise UserError("theatre: --new needs --out FILE.toml")
    from subsea.stage.plan import NewTheatre, write_theatre

    return write_theatre(
        NewTheatre(
            options.new, given, options.out, options.picture, options.computers, options.force
        )
    )
