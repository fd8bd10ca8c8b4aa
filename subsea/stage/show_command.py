"""`subsea show`: check a show and print its timetable."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command

GROUP = "scenarios and theatres"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "show",
        "check a show and print the timetable of today",
        "Lists the items of a file for `subsea dive --playlist`. Exit code 1 if a scenario or a\n"
        "tour is missing. The keys of the file: docs/reference/show-file.md.",
        ["subsea show show.toml"],
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="a .toml file")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print the timetable; 1 if an item cannot be shown."""
    from subsea.stage.show_player import describe_show

    return describe_show(options.file)
