"""`subsea study`: measure a record."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command, add_force


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "study",
        "measure a record",
        "Prints a table: collisions, time budgets, schools, escapes, captures, matings, meals.\n"
        "docs/reference/records.md defines every measure. Plots need the extra `plot`.",
        [
            "subsea study run.h5",
            "subsea study run.h5 --out plots --json run.json",
        ],
    )
    parser.add_argument("record", metavar="RECORD.h5", type=Path, help="from `subsea simulate`")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for plots (PNG)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the measures")
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Measure the record and print a table."""
    from subsea.study.report import study

    return study(options.record, options.out, options.json, options.force)
