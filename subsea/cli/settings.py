"""`subsea settings`: show or write the settings file."""

from argparse import Namespace
from typing import Any

from subsea.core.command_line import add_command


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "settings",
        "show where the settings of a dive are, or write them there",
        "Keys, mouse, gamepad, comfort and the picture, in one commented file, described in\n"
        "docs/settings.md.",
        ["subsea settings", "subsea settings --write"],
    )
    parser.add_argument(
        "--write", action="store_true", help="write a file with all the defaults, if there is none"
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Show or write the settings."""
    from subsea.dive.settings import show_settings

    return show_settings(options.write)
