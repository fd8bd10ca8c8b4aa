"""`subsea settings`: show or write the settings file."""

from argparse import Namespace
from typing import Any

from subsea.base.command_line import add_command

GROUP = "this machine"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "settings",
        "print the path of the settings file, or write it",
        "Keys, mouse, gamepad, comfort and display: docs/reference/settings.md.",
        ["subsea settings", "subsea settings --write"],
    )
    parser.add_argument(
        "--write", action="store_true", help="write a commented file with all defaults"
    )
    parser.add_argument("--force", action="store_true", help="replace an existing settings file")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Show or write the settings."""
    from subsea.dive.settings import show_settings

    return show_settings(options.write, options.force)
