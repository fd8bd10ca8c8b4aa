"""`subsea study`: measure a record, or compare several."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command, add_force


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "study",
        "measure a record, or compare several",
        "Prints a table: collisions, time budgets, schools, escapes, captures, matings, meals.\n"
        "Of several records: the mean of each measure and its 95% confidence interval (Student's\n"
        "t), for each group of records with equal scenario and changes.\n"
        "docs/reference/records.md defines every measure. Plots need the extra `plot`.",
        [
            "subsea study run.h5",
            "subsea study run.h5 --out plots --json run.json",
            "subsea study seed_1.h5 seed_2.h5 shy_1.h5 shy_2.h5 --out plots",
        ],
    )
    parser.add_argument(
        "records", metavar="RECORD.h5", type=Path, nargs="+", help="from `subsea simulate`"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for plots (PNG)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the measures")
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Measure the records and print a table."""
    if len(options.records) > 1:
        from subsea.study.comparison import compare

        return compare(options.records, options.out, options.json, options.force)
    from subsea.study.report import study

    return study(options.records[0], options.out, options.json, options.force)
