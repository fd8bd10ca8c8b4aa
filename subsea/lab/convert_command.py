"""`subsea convert`: write the fishes of a record as tracks for other programs."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.progress import print_line

GROUP = "simulate and study"  # in the help
TARGETS = "movement", "deeplabcut", "trajr", "idtrackerai"


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "convert",
        "write a record as tracks for other programs",
        "Writes snout, centre of mass and tail of each fish in each tick, or its centre alone.\n"
        "Targets:\n"
        "  movement     netCDF, in cm: OUT.nc; needs the extra `tracks`\n"
        "  deeplabcut   OUT.csv, or OUT.h5 with the extra `tracks`; in pixels\n"
        "  trajr        a folder with a CSV file for each fish, in cm\n"
        "  idtrackerai  trajectories as OUT.h5 or OUT.npy, in pixels",
        [
            "subsea convert run.h5 --to deeplabcut --out tracks.csv",
            "subsea convert run.h5 --to trajr --out tracks",
            "subsea convert run.h5 --to idtrackerai --out trajectories.npy --px-per-cm 4",
        ],
    )
    parser.add_argument("record", metavar="RECORD.h5", type=Path, help="from `subsea simulate`")
    parser.add_argument(
        "--to", required=True, choices=TARGETS, metavar="TARGET", help=", ".join(TARGETS)
    )
    parser.add_argument("--out", type=Path, required=True, metavar="OUT", help="what to write")
    parser.add_argument(
        "--view",
        choices=("top", "side"),
        metavar="VIEW",
        help="deeplabcut, idtrackerai: seen from the top (default) or the side",
    )
    parser.add_argument(
        "--px-per-cm",
        type=number_reader(float, 0.001, 1000),
        metavar="N",
        help="deeplabcut, idtrackerai: pixels per cm (default 1)",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Write the tracks."""
    from subsea.lab.report import refuse_clashes
    from subsea.lab.tracks import FlatView, convert
    from subsea.media.record import read_record

    view = None
    if options.view is not None or options.px_per_cm is not None:
        view = FlatView(options.view or "top", options.px_per_cm or 1.0)
    refuse_clashes([options.record], [options.out])
    convert(read_record(options.record), options.to, options.out, view, options.force)
    print_line(options.out)
    return 0
