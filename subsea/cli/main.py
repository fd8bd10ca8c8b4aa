"""The entry point of `subsea`: check a command and its options before heavy imports."""

import argparse
import gc
import sys
from collections.abc import Callable, Sequence
from typing import Any

from subsea.base.command_line import add_groups, make_parser, parse_arguments, run_command
from subsea.base.registry import COMMANDS, load_all
from subsea.cli import dive, doctor, film, listing, logbook, settings

GROUPS = (
    "dive and film", "simulate and study", "make fishes", "scenarios and theatres", "this machine",
)  # fmt: skip
OWN = {
    "dive": dive, "doctor": doctor, "film": film, "list": listing, "logbook": logbook,
    "settings": settings,
}  # fmt: skip


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
    """Return the parser of `subsea` and its commands: those of the house, and registered ones."""
    parser = make_parser("subsea", "A submarine among artificial fishes.")
    modules = dict(load_all(COMMANDS)) | OWN
    return parser, add_groups(parser, GROUPS, modules)
