"""`subsea soak`: dive for hours with random input and check invariants."""

import argparse
from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.cli import options as shared
from subsea.core.command_line import add_command, number_reader


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "soak",
        "dive for hours with random input, and check invariants",
        "Steers, takes the reins of fishes, changes current and lights, rewinds time, and draws\n"
        "in one display mode and theatre after another. Reports numbers that are not finite,\n"
        "fishes out of the sea, inside rock or stuck, a rewound past that repeats differently,\n"
        "and memory that grows. Exit code 1 if anything was found.",
        [
            "subsea soak --minutes 60",
            "subsea soak --scenario open-ocean --minutes 5 --json soak.json",
            "subsea soak --scenario open-ocean --minutes 5 --compare soak.json",
        ],
    )
    shared.add_scenario(parser)
    shared.add_fish(parser)
    shared.add_seed(parser)
    parser.add_argument(
        "--minutes",
        type=number_reader(float, 0.01, 1440),
        default=10.0,
        metavar="M",
        help="simulated time (default 10)",
    )
    parser.add_argument(
        "--draw",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="draw a picture every simulated second (--no-draw: no OpenGL)",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a report there")
    parser.add_argument(
        "--compare",
        type=Path,
        metavar="FILE",
        help="expect the checksums in this report of the same soak",
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Soak; 1 if anything was found."""
    from subsea.profiling.soak import soak

    return soak(
        options.scenario,
        options.minutes,
        options.fish,
        options.seed,
        options.draw,
        options.json,
        options.compare,
        options.changes,
    )
