"""`subsea keys`: make the keys of a theatre's computers."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command
from subsea.base.progress import print_line

GROUP = "scenarios and theatres"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "keys",
        "make the keys of a theatre's computers",
        "Writes NAME.key for all computers and NAME.key_secret for that computer only:\n"
        "docs/how-to/cluster.md.",
        ["subsea keys keys/ middle left right"],
    )
    parser.add_argument("folder", metavar="DIR", type=Path, help="folder to write into")
    parser.add_argument("names", metavar="NAME", nargs="+", help="a node of the theatre")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Write the keys and print their names."""
    from subsea.stage.cluster.keys import write_keys

    for path in write_keys(options.folder, options.names):
        print_line(path)
    return 0
