"""`subsea theatre`: check a theatre file."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command, add_force


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "theatre",
        "check a theatre file and list its contents",
        "Lists windows, channels, screens, meshes and masks. Exit code 1 if a channel does not\n"
        "work. The keys of the file: docs/reference/theatre-file.md.",
        [
            "subsea theatre three-projectors",
            "subsea theatre my/theatre.toml",
            "subsea theatre dome.json --write dome.toml",
        ],
    )
    parser.add_argument(
        "name", metavar="NAME|FILE", help="name, .toml file or another program's file"
    )
    parser.add_argument(
        "--write", metavar="OUT.toml", type=Path, help="write it as a theatre file of our own"
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Describe the theatre; 1 if a part of it does not work."""
    from subsea.dive.theatre_setup import describe

    return describe(options.name, options.write, options.force)
