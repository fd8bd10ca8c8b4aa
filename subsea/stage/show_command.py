"""`subsea show`: check a show and print its timetable."""

from argparse import Namespace
from typing import Any

from subsea.base.command_line import add_command

GROUP = "scenarios and theatres"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "show",
        "check a show and print the timetable of today",
        "Lists the items of a show for `subsea dive --playlist`. Exit code 1 if a scenario or a\n"
        "tour is missing. The keys of the file: docs/reference/show-file.md.",
        ["subsea show show.toml", "subsea show go-fish"],
    )
    parser.add_argument("show", metavar="SHOW", help="a .toml file or a shipped show")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print the timetable; 1 if an item cannot be shown."""
    from subsea.stage.cue_parts import check_cues
    from subsea.stage.show_file import load_show, show_path
    from subsea.stage.show_player import describe_show

    path = show_path(options.show)
    check_cues(load_show(path), path)
    return describe_show(path)
