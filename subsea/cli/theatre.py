"""`subsea theatre`: check a theatre file."""

from argparse import Namespace
from typing import Any

from subsea.core.command_line import add_command


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "theatre",
        "list the contents of a theatre file and check them",
        "Windows, channels, screens, meshes and masks, without opening a window. Exit code 1 if\n"
        "a channel does not work. docs/theatre.md explains how to write such a file.",
        ["subsea theatre three-projectors", "subsea theatre my/theatre.toml"],
    )
    parser.add_argument("name", metavar="NAME|FILE", help="a theatre's name or a .toml file")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Describe the theatre; 1 if a part of it does not work."""
    from subsea.dive.theatre_setup import describe

    return describe(options.name)
