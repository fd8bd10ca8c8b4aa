"""`subsea build`: build a fish in a window."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "build",
        "build a fish in a window: outline, scaffold, muscles",
        "A new species begins as a copy of another one and is saved in your own folder. Drag its\n"
        "points in a side view and a top view; beside them it swims by its own muscles, and\n"
        "checks list what is missing. Learn and Record make it swim in the sea: docs/builder.md.",
        ["subsea build", "subsea build clownfish", "subsea build my_fish --over fish.jpg"],
    )
    parser.add_argument(
        "name", metavar="SPECIES", nargs="?", help="species, or the path of its .toml file"
    )
    parser.add_argument(
        "--in-place",
        action="store_true",
        help="save a species that comes with the program into its own file, not under a new name",
    )
    parser.add_argument(
        "--over",
        type=Path,
        metavar="PHOTO",
        help="show a photograph from the side behind the side view, to draw over",
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Open the builder."""
    from subsea.ui.fish_builder.window import build

    return build(options.name, options.in_place, options.over)
