"""`subsea sweep`: run every combination of seeds and values."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError
from subsea.dive import arguments as shared
from subsea.lab.simulate_command import add_length, ticks_of

GROUP = "simulate and study"  # in the help
MAX_JOBS = 256


def seeds(text: str) -> tuple[int, ...]:
    """Read seeds."""
    from subsea.lab.sweep import read_seeds

    return read_seeds(text)


def add_jobs(parser: Any) -> None:
    """Add --jobs."""
    parser.add_argument(
        "--jobs",
        type=number_reader(int, 1, MAX_JOBS),
        metavar="N",
        help="parallel processes (default: one for each core)",
    )


def check_jobs(options: Namespace) -> None:
    """Raise a UserError for both processes and a cluster, or for certificates without one."""
    if options.cluster is not None and options.jobs is not None:
        raise UserError("--jobs and --cluster: give one of the two")
    if options.cluster is None and options.cluster_tls is not None:
        raise UserError("--cluster-tls needs --cluster")


def pool_of(options: Namespace) -> Any:
    """Return the cluster or the processes that do the work; compile the kernels for the latter."""
    from subsea.base.progress import say
    from subsea.base.system import cores
    from subsea.dive.warm_up import warm_up
    from subsea.jobs.dask_cluster import dask_pool
    from subsea.jobs.workers import process_pool

    if options.cluster is not None:
        return dask_pool(options.cluster, options.cluster_tls)
    warm_up(say)
    return process_pool(options.jobs or cores())


def add(commands: Any) -> None:
    """Add the command."""
    from subsea.jobs.dask_cluster import add_cluster
    from subsea.lab.measure_option import add_measures

    parser = add_command(
        commands,
        "sweep",
        "run a scenario with many seeds and values",
        "Runs every combination of seeds and values, and writes the measures of each run\n"
        "(docs/reference/records.md) as a row of DIR/sweep.parquet. Needs the extra `sweep`, or\n"
        "--csv. The same command continues an interrupted sweep and makes no run again.",
        [
            "subsea sweep schooling --seeds 1:64 --seconds 60 --out schools",
            "subsea sweep schooling --seeds 1:8 --seconds 60 --set nature.timidity=1,2 --out shy",
            "subsea sweep peaceful --seeds 1,5 --seconds 10 --csv --out few",
            "subsea sweep peaceful --seeds 1 --seconds 10 --draw nature.keen=0:1 --points 4 "
            "--design sobol --out drawn",
        ],
    )
    parser.add_argument("scenario", metavar="SCENARIO", help="name or .toml file")
    parser.add_argument(
        "--seeds", type=seeds, required=True, metavar="LIST", help="such as 1:64 or 1,5,9"
    )
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=A,B,…",
        help="values of a key of the scenario; commas in brackets and quotes belong to a value",
    )
    parser.add_argument(
        "--draw",
        dest="ranges",
        action="append",
        default=[],
        metavar="KEY=LEAST:MOST",
        help="draw values of a key from this range, for as many points as --points says",
    )
    parser.add_argument(
        "--points",
        metavar="N|FILE.csv",
        help="with --draw: number of points; else a table of points, whose first line has the keys",
    )
    parser.add_argument(
        "--design",
        choices=("latin", "sobol"),
        help="with --draw: Latin hypercube (default), or Sobol sequence (extra `sobol`)",
    )
    parser.add_argument(
        "--draw-seed",
        type=number_reader(int, 0, 2**32 - 1),
        metavar="N",
        help="with --draw: seed of the draw (default 0)",
    )
    add_length(parser)
    shared.add(parser, "fish")
    add_measures(parser)
    add_jobs(parser)
    add_cluster(parser)
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder for the results"
    )
    parser.add_argument(
        "--csv", action="store_true", help="write sweep.csv, too; then PyArrow is not needed"
    )
    parser.add_argument("--records", action="store_true", help="keep DIR/records/RUN.h5")
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Run the sweep."""
    from subsea.base.interrupts import deferred_interrupts
    from subsea.lab.own_measures import named_measures
    from subsea.lab.sweep import Sweep, read_values, sweep

    check_jobs(options)
    values = read_values(options.settings)
    chosen = Sweep(
        options.scenario, options.seeds, ticks_of(options), options.fish, values, _points(options),
        named_measures(options.measures),
    )  # fmt: skip
    pool = pool_of(options)
    with deferred_interrupts() as check:
        table = sweep(
            chosen,
            options.out,
            pool=pool,
            csv=options.csv,
            records=options.records,
            force=options.force,
            check=check,
        )
    print(table)
    return 0


def _points(options: Namespace) -> list[dict[str, Any]]:
    """Draw the points of a design, or read a table of points."""
    from subsea.lab.designs import DESIGNS, MOST_POINTS, read_points, read_ranges

    if not options.ranges:
        for name in ("design", "draw_seed"):
            if getattr(options, name) is not None:
                raise UserError(f"--{name.replace('_', '-')} needs --draw")
        return [] if options.points is None else read_points(Path(options.points))
    number = options.points or ""
    if not number.isdecimal() or not 1 <= int(number) <= MOST_POINTS:
        raise UserError(f"--draw needs --points N, a number of points from 1 to {MOST_POINTS:,}")
    draw = DESIGNS[options.design or "latin"]
    return draw(read_ranges(options.ranges), int(number), options.draw_seed or 0)
