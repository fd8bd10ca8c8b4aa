"""`subsea soak`: dive for hours with random input and check invariants."""

import argparse
from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError
from subsea.base.registry import SOAKS, load_named
from subsea.dive import arguments as shared

GROUP = "simulate and study"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "soak",
        "dive with random input and check invariants",
        "Steers submarine and fishes, changes current and lights, rewinds time, and draws in all\n"
        "display modes and theatres. Reports NaN and infinity, fishes outside the sea, inside\n"
        "rock or stuck, replays that differ, and memory leaks. Exit code 1 for any of these.",
        [
            "subsea soak --kiosk --minutes 30",
            "subsea soak --minutes 60",
            "subsea soak --scenario open-ocean --minutes 5 --json soak.json",
            "subsea soak --scenario open-ocean --minutes 5 --compare soak.json",
        ],
    )
    shared.add(parser, *shared.SCENARIO, "fish", "seed")
    parser.add_argument(
        "--minutes",
        type=number_reader(float, 0.01, 1440),
        default=10.0,
        metavar="M",
        help="simulated time, of a kiosk real time (default 10)",
    )
    parser.add_argument(
        "--draw",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="draw a picture every simulated second; --no-draw needs no OpenGL",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a report")
    parser.add_argument(
        "--compare",
        type=Path,
        metavar="FILE",
        help="compare checksums with a report of the same soak",
    )
    group = parser.add_argument_group("a kiosk", "in real time, on this display")
    group.add_argument(
        "--kiosk",
        action="store_true",
        help="start a real kiosk, cut its power at random moments, and fill its disk",
    )
    group.add_argument("--playlist", type=Path, metavar="FILE", help="show of the kiosk")
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Soak; 1 if anything was found."""
    if options.kiosk:
        shared.refuse(options, ("json", "compare", "fish"), "soak: --kiosk goes without {}")
        if options.changes:
            raise UserError("soak: --kiosk goes without --set")
        soak_kiosk = load_named(SOAKS, "kiosk", "soak")
        code: int = soak_kiosk(options.scenario, options.minutes, options.seed, options.playlist)
        return code
    shared.refuse(options, ("playlist",), "soak: {} needs --kiosk")
    from subsea.base.file_kinds import check_result
    from subsea.lab.soak import REPORT, soak

    if options.json is not None:
        check_result(options.json, REPORT, options.force)
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
