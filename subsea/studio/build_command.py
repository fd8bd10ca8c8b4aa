"""`subsea build`: build a fish in a window."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command

GROUP = "make fishes"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "build",
        "build a fish in a window",
        "Starts from a copy of a species, which is saved in your own folder. Drag its points in a\n"
        "side view and a top view; a preview swims by its own muscles, and checks list what is\n"
        "missing. Learn and Record make it swim in the sea: docs/how-to/builder.md.",
        ["subsea build", "subsea build clownfish", "subsea build my_fish --over fish.jpg"],
    )
    parser.add_argument(
        "name", metavar="SPECIES", nargs="?", help="species, or the path of its .toml file"
    )
    parser.add_argument(
        "--in-place",
        action="store_true",
        help="save a shipped species to its own file",
    )
    parser.add_argument(
        "--over",
        type=Path,
        metavar="PHOTO",
        help="photograph to trace in the side view",
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Open the builder."""
    from subsea.studio.builder.window import build

    return build(options.name, options.in_place, options.over)
