"""The entry point of `subsea`: check a command and its options before heavy imports."""

import argparse
import gc
import sys
from collections.abc import Callable, Sequence
from typing import Any

from subsea.cli import (
    benchmark,
    build,
    dive,
    doctor,
    film,
    keys,
    settings,
    simulate,
    skin,
    soak,
    study,
    theatre,
)
from subsea.core.command_line import make_parser, parse_arguments, run_command

COMMANDS = (
    dive, film, theatre, simulate, study, benchmark, soak, skin, build, doctor, keys, settings,
)  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `subsea` with these arguments (default: the process's) and return its exit code.

    0 done, 1 a negative finding of `doctor`, `soak` or `theatre`, 2 an error that the user can fix
    (one line on standard error), 130 interrupted.
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


class _Version(argparse.Action):
    """Looks up the version only on request: that takes longer than all other parsing."""

    def __call__(self, parser: argparse.ArgumentParser, *unused: object) -> None:
        from importlib.metadata import version

        print(f"subsea {version('subsea')}")
        parser.exit()


def parsers() -> tuple[argparse.ArgumentParser, Any]:
    """Return the parser of `subsea` and its commands."""
    parser = make_parser("subsea", "A submarine among artificial fishes.")
    parser.add_argument(
        "--version",
        action=_Version,
        nargs=0,
        default=argparse.SUPPRESS,
        help="show the version and exit",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for module in COMMANDS:
        module.add(commands)
    return parser, commands
