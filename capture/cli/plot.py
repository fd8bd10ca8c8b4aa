"""`subsea-capture plot`: draw the motion of a repertoire."""

import argparse
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force
from subsea.base.file_kinds import PICTURE, check_results
from subsea.base.files import check_folder

GROUP = "record and measure"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "plot",
        "draw the motion of a repertoire",
        "Writes a PNG file for each segment (film strip, trajectories, speed, tail, spectrum,\n"
        "loop closure) and one for the repertoire (paths, speeds, steering map). Needs the\n"
        "extra `plot`.",
        ["subsea-capture plot fusilier --out plots"],
    )
    parser.add_argument("file", metavar="SPECIES", help="species, or path of a repertoire (.h5)")
    parser.add_argument("--out", metavar="DIR", type=Path, required=True, help="folder to write to")
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.plots.pages import plot_repertoire, plots_in
    from subsea.fish.species import repertoire_file
    from subsea.repertoire import read_repertoire

    repertoire = read_repertoire(repertoire_file(options.file))
    check_folder(options.out)
    check_results(plots_in(options.out, repertoire), PICTURE, options.force)
    for path in plot_repertoire(repertoire, options.out):
        print(path)
    return 0
