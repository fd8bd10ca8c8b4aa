"""`subsea study`: measure a record, compare several, or compare seas with measured fishes."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError
from subsea.base.report_files import add_report_options
from subsea.lab.measure_option import add_measures
from subsea.lab.sweep_command import add_jobs, seeds

MAX_SECONDS = 3600
GROUP = "simulate and study"  # in the help
SEEDS, SECONDS, HUNT_SECONDS = "1-3", 60.0, 180.0
NAME = "subsea study --validate"


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "study",
        "measure a record, compare several, or compare seas with measured fishes",
        "Prints a table: collisions, time budgets, schools, escapes, captures, matings, meals.\n"
        "Of several records: the mean of each measure and its 95% confidence interval (Student's\n"
        "t), for each group of records with equal scenario and changes.\n"
        "docs/reference/records.md defines every measure. With --validate it runs scenarios and\n"
        "compares how fishes swim, school and hunt with measured fishes (assets/swimming.toml).\n"
        "Plots need the extra `plot`.",
        [
            "subsea study run.h5",
            "subsea study run.h5 --out plots --json run.json",
            "subsea study seed_1.h5 seed_2.h5 shy_1.h5 shy_2.h5 --out plots",
            "subsea study --validate --seeds 1-20 --seconds 300 --report validation.md",
            "subsea study --validate schooling --seeds 1,5 --json schools.json",
        ],
    )
    parser.add_argument(
        "records", metavar="RECORD.h5", type=Path, nargs="*",
        help="from `subsea simulate`; with --validate names of scenarios (default: all)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for plots (PNG)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the measures")
    add_measures(parser)
    validate = parser.add_argument_group("validation", "Only with --validate.")
    validate.add_argument(
        "--validate", action="store_true", help="run scenarios; compare with measured fishes"
    )
    validate.add_argument(
        "--seeds", type=seeds, metavar="LIST", help=f"such as 1-20 or 1,5,9 (default {SEEDS})"
    )
    validate.add_argument(
        "--seconds", type=number_reader(float, 0.1, MAX_SECONDS), metavar="S",
        help=f"length of each run (default {SECONDS:g}; of preying {HUNT_SECONDS:g})",
    )  # fmt: skip
    add_jobs(validate)
    add_report_options(validate)
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Measure the records, or validate scenarios, and print a table."""
    if options.validate:
        return _validate(options)
    for name in ("seeds", "seconds", "jobs", "report", "plots"):
        if getattr(options, name) is not None:
            raise UserError(f"study: --{name} needs --validate")
    if not options.records:
        raise UserError("study: expected RECORD.h5, or --validate")
    from subsea.lab.own_measures import named_measures

    own = named_measures(options.measures)
    if len(options.records) > 1:
        from subsea.lab.comparison import compare

        return compare(options.records, options.out, options.json, options.force, own)
    from subsea.lab.report import study

    return study(options.records[0], options.out, options.json, options.force, own)


def _validate(options: Namespace) -> int:
    """Run the scenarios and compare."""
    from subsea.base.interrupts import deferred_interrupts
    from subsea.base.progress import say
    from subsea.base.report_files import ReportFiles
    from subsea.base.system import cores
    from subsea.dive.warm_up import warm_up
    from subsea.jobs.workers import process_pool
    from subsea.lab.validation import VALIDATION_PLOTS, default_scenarios, trials, validate
    from subsea.world.world import TICK_S

    if options.out is not None:
        raise UserError("study: --out is for records; with --validate give --plots")
    names = [str(name) for name in options.records] or default_scenarios()
    times = (options.seconds or SECONDS, options.seconds or HUNT_SECONDS)
    ticks, hunt_ticks = (max(round(seconds / TICK_S), 1) for seconds in times)
    chosen = options.seeds or seeds(SEEDS)
    jobs = list(trials(names, chosen, ticks, hunt_ticks))
    files = ReportFiles(NAME, options.json, options.report, options.plots)
    files.check(VALIDATION_PLOTS, options.force)
    warm_up(say)
    with deferred_interrupts() as check:
        validate(jobs, files, process_pool(options.jobs or cores()), check)
    return 0
