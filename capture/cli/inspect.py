"""`subsea-capture inspect`: show a repertoire and measure its motion."""

import argparse
from typing import Any

from subsea.base.command_line import add_command

GROUP = "record and measure"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "inspect",
        "list the segments of a repertoire and measure its motion",
        "Simulates the fish again from the file's provenance and compares each measure with a\n"
        "limit and an aim. Exit code 1 if a limit is not kept; a missed aim is not a failure.",
        ["subsea-capture inspect fusilier", "subsea-capture inspect repertoires/fusilier.h5"],
    )
    parser.add_argument("file", metavar="SPECIES", help="species, or path of a repertoire (.h5)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.inspection.report import report
    from subsea.fish.species import repertoire_file

    return 0 if report(repertoire_file(options.file), lambda line: print(line, flush=True)) else 1
