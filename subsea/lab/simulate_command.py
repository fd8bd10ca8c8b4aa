"""`subsea simulate`: record every fish, without pictures."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.progress import print_line
from subsea.dive import arguments as shared

GROUP = "simulate and study"  # in the help
MAX_TICKS = 100_000_000


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "simulate",
        "record what every fish does",
        "Writes an HDF5 file for studies. Needs no OpenGL. After an interruption the file has the\n"
        "ticks so far.",
        [
            "subsea simulate --seconds 60 --out run.h5",
            "subsea simulate --ticks 9000 --out run.h5 --fish 400 --seed 7",
            "subsea simulate --ticks 900 --out run.h5 --set nature.keen=0.4 --set fish.0.hunger=1",
        ],
    )
    add_length(parser)
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE.h5", help="record to write"
    )
    shared.add(parser, *shared.SCENARIO, "fish", "seed")
    add_force(parser)
    parser.set_defaults(run=run)


def add_length(parser: ArgumentParser) -> None:
    """Add --ticks and --seconds."""
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument(
        "--ticks",
        type=number_reader(int, 1, MAX_TICKS),
        metavar="N",
        help="length of the run in ticks of 0.033 s",
    )
    length.add_argument(
        "--seconds",
        type=number_reader(float, 0.033, 0.033 * MAX_TICKS),
        metavar="S",
        help="length of the run in seconds, rounded to ticks; instead of --ticks",
    )


def ticks_of(options: Namespace) -> int:
    """Compute the length of a run in ticks."""
    from subsea.base.progress import say
    from subsea.world.world import TICK_S

    if options.ticks is not None:
        return int(options.ticks)
    ticks = round(options.seconds / TICK_S)
    say(f"{options.seconds:g} s are {ticks} ticks of {TICK_S:g} s")
    return ticks


def run(options: Namespace) -> int:
    """Record the run."""
    from subsea.lab.simulate import simulate

    extent = simulate(
        ticks_of(options),
        options.out,
        options.scenario,
        options.fish,
        options.seed,
        options.changes,
        options.force,
    )
    print_line(f"{options.out}: {extent}")
    return 0
