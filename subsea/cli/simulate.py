"""`subsea simulate`: record every fish, without pictures."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.cli import options as shared
from subsea.core.command_line import add_command, number_reader


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "simulate",
        "record what every fish does, without pictures",
        "Writes an HDF5 file for the study of the fishes. Needs no OpenGL. An interrupted run\n"
        "leaves a valid file with the ticks so far.",
        [
            "subsea simulate --ticks 1000 --out run.h5",
            "subsea simulate --ticks 9000 --out run.h5 --fish 400 --seed 7",
            "subsea simulate --ticks 900 --out run.h5 --set nature.keen=0.4 --set fish.0.hunger=1",
        ],
    )
    parser.add_argument(
        "--ticks",
        type=number_reader(int, 1, 100_000_000),
        required=True,
        metavar="N",
        help="length of the run; a tick is 33 ms",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.h5")
    shared.add_scenario(parser)
    shared.add_fish(parser)
    shared.add_seed(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Record the run."""
    from subsea.study.simulate import simulate

    return simulate(
        options.ticks, options.out, options.scenario, options.fish, options.seed, options.changes
    )
