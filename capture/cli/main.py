"""The command line of the capture tool: its commands and its exit codes."""

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from capture.cli import fit, flat, inspect, learn, plot, record, validate
from subsea.base.command_line import add_groups, make_parser, parse_arguments, run_command
from subsea.base.registry import CAPTURE_COMMANDS, load_all

GROUPS = "record and measure", "learn to swim", "use elsewhere"
OWN = {
    "fit": fit, "flat": flat, "inspect": inspect, "learn": learn, "plot": plot, "record": record,
    "validate": validate,
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``subsea-capture`` with these arguments (default: the process's); return its exit code.

    0 done, 1 a fish misses a target of `inspect` or `learn` found nothing better, 2 a fault that
    the user can mend (one line on standard error), 130 interrupted.
    """
    return run_command(
        "subsea-capture", lambda: _run(sys.argv[1:] if arguments is None else arguments)
    )


def _run(arguments: Sequence[str]) -> int:
    parser, commands = parsers()
    if not arguments:
        parser.print_help()
        return 0
    options = parse_arguments(parser, commands, arguments)
    code: int = options.run(options)
    return code


def parsers() -> tuple[argparse.ArgumentParser, Any]:
    """The parser of ``subsea-capture`` and its commands."""
    parser = make_parser("subsea-capture", "Record the motion of simulated fishes, and measure it.")
    return parser, add_groups(parser, GROUPS, dict(load_all(CAPTURE_COMMANDS)) | OWN)
