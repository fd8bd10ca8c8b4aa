"""`subsea benchmark`: measure the time of every stage of a frame."""

from argparse import ArgumentTypeError, Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError, unknown
from subsea.dive import arguments as shared

GROUP = "simulate and study"  # in the help
STAGES_TO_LEAVE_OUT = ("culling", "lod", "sync")


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "benchmark",
        "measure the time of each stage of a frame",
        "Each frame is one tick of the world and one picture, without a window;\n"
        "docs/developers/benchmarks.md gives the formula of every figure. --paper\n"
        "measures what the 1999 paper measured.",
        [
            "subsea benchmark --frames 120 --json report.json",
            "subsea benchmark --fish 60,1000,10000 --tour reef --compare report.json",
            "subsea benchmark --fish 1000 --without culling,lod",
            "subsea benchmark --fish 200 --motor dynamics",
            "subsea benchmark --paper",
        ],
    )
    shared.add(parser, *shared.SCENARIO)
    parser.add_argument(
        "--fish",
        type=_fish_counts,
        default=(None,),
        metavar="N,…",
        help="total numbers of fishes, measured in turn (default: the scenario's)",
    )
    shared.add(parser, "tour")
    parser.add_argument(
        "--frames",
        type=number_reader(int, 1, 100_000),
        default=120,
        metavar="N",
        help="frames to measure after the warm-up (default 120)",
    )
    shared.add(parser, "theatre", "shrink", "size")
    shared.add_quality(parser, "low")
    shared.add(parser, "target-ms", "display", "seed")
    parser.add_argument(
        "--without",
        type=_left_out,
        default=frozenset(),
        metavar="LIST",
        help="stages to leave out, separated by commas: culling, lod, sync (pictures are not read\n"
        "back, and drawn while the next frame is computed, as in a dive)",
    )
    parser.add_argument(
        "--motor",
        choices=("playback", "dynamics"),
        default="playback",
        metavar="MOTOR",
        help="playback (default) or dynamics: simulate every fish with muscles",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the report")
    parser.add_argument(
        "--compare",
        type=Path,
        metavar="FILE",
        help="compare with an older report of --json",
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the times of each frame")
    parser.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="plot the times of each frame (PNG); needs the extra `plot`",
    )
    parser.add_argument(
        "--paper",
        action="store_true",
        help="print tables 3 and 4 of the 1999 paper for this machine",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def _fish_counts(text: str) -> tuple[int, ...]:
    one = number_reader(int, 1, 100_000)
    counts = tuple(int(one(part.strip())) for part in text.split(","))
    if len(set(counts)) < len(counts):
        raise ArgumentTypeError(f"{text!r}: expected every number once")
    return counts


def _left_out(text: str) -> frozenset[str]:
    words = [word.strip() for word in text.split(",") if word.strip()]
    for word in words:
        if word not in STAGES_TO_LEAVE_OUT:
            raise unknown("stage to leave out", word, list(STAGES_TO_LEAVE_OUT))
    return frozenset(words)


def run(options: Namespace) -> int:
    """Measure and print the report."""
    if options.paper:
        for word in options.words:
            if word != "--paper":
                raise UserError(f"benchmark: --paper takes no other option, {word!r} was given")
        from subsea.lab.paper_tables import paper_tables

        return paper_tables()
    from subsea.lab.benchmark import BenchmarkOptions, benchmark

    shared.check_display_without_window(options.display)
    shared.check_target(options)
    shared.settle_size(options)
    return benchmark(BenchmarkOptions(**shared.fields_of(BenchmarkOptions, options)))
