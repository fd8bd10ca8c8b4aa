"""The entry point of `subsea`: check a command and its options before heavy imports."""

import argparse
import gc
import sys
from collections.abc import Callable, Sequence
from typing import Any

from subsea.base.command_line import add_groups, make_parser, parse_arguments, run_command
from subsea.cli import dive, doctor, film, listing, settings
from subsea.export import command as export
from subsea.lab import benchmark_command as benchmark
from subsea.lab import simulate_command as simulate
from subsea.lab import soak_command as soak
from subsea.lab import study_command as study
from subsea.lab import sweep_command as sweep
from subsea.stage import show_command as show
from subsea.stage import theatre_command as theatre
from subsea.stage.cluster import keys_command as keys
from subsea.studio import build_command as build
from subsea.studio import skin_command as skin

GROUPS = {
    "dive and film": (dive, film, export),
    "simulate and study": (simulate, study, sweep, benchmark, soak),
    "make fishes": (build, skin),
    "scenarios and theatres": (listing, theatre, keys, show),
    "this machine": (doctor, settings),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `subsea` with these arguments (default: the process's) and return its exit code.

    0 done, 1 a negative finding of `doctor`, `soak` or `theatre`, 2 an error that the user can fix,
    75 one that may also pass by itself (one line on standard error), 130 interrupted.
    """
    # A start allocates a million objects that stay: collect less often.
    gc.set_threshold(100_000)
    return run_command("subsea", lambda: run(sys.argv[1:] if arguments is None else arguments))


def run(arguments: Sequence[str]) -> int:
    """Run `subsea` and return its exit code; errors of the user are raised as UserError."""
    parser, commands = parsers()
    if not arguments:
        parser.print_help()
        return 0
    options = parse_arguments(parser, commands, arguments)
    options.words = arguments[1:]
    run_command: Callable[[argparse.Namespace], int] = options.run
    return run_command(options)


def parsers() -> tuple[argparse.ArgumentParser, Any]:
    """Return the parser of `subsea` and its commands."""
    parser = make_parser("subsea", "A submarine among artificial fishes.")
    return parser, add_groups(parser, GROUPS)
