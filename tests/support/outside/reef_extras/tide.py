"""`subsea tide`: a command of another package."""

from argparse import Namespace
from typing import Any

from subsea.base.command_line import add_command

GROUP = "from other packages"


def add(commands: Any) -> None:
    """Add the command."""
    text = "Prints the level of the tide."
    add_command(commands, "tide", "tell the tide", text, ["subsea tide"]).set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print the level."""
    print("the tide is high")
    return 0
