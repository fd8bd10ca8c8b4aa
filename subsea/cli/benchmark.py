"""`subsea benchmark`: measure the time of every stage of a frame."""

from argparse import ArgumentTypeError, Namespace
from pathlib import Path
from typing import Any

from subsea.cli import options as shared
from subsea.core.command_line import add_command, number_reader
from subsea.core.errors import UserError, unknown

MOTORS = ("playback", "dynamics")
STAGES_TO_LEAVE_OUT = ("culling", "lod")


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "benchmark",
        "measure how long every stage of a frame takes",
        "Each frame is one tick of the world and one picture, without a window; docs/diving.md\n"
        "gives the formula of every figure. --paper measures what the 1999 paper measured.",
        [
            "subsea benchmark --frames 120 --json report.json",
            "subsea benchmark --fish 60,1000,10000 --tour reef --compare report.json",
            "subsea benchmark --fish 1000 --without culling,lod",
            "subsea benchmark --fish 200 --motor dynamics",
            "subsea benchmark --paper",
        ],
    )
    shared.add_scenario(parser)
    parser.add_argument(
        "--fish",
        type=_fish_counts,
        metavar="N,…",
        help="total number of fishes, instead of the scenario's; several, separated by commas, "
        "are measured one after another",
    )
    parser.add_argument(
        "--tour",
        default="auto",
        metavar="NAME",
        help="one of the scenario's tours, directed, or auto, which goes where something happens "
        "(default auto)",
    )
    parser.add_argument(
        "--frames",
        type=number_reader(int, 1, 100_000),
        default=120,
        metavar="N",
        help="frames that count, after the warm-up (default 120)",
    )
    shared.add_theatre(parser)
    shared.add_size(parser)
    shared.add_quality(parser, "low")
    shared.add_target(parser)
    shared.add_display(parser)
    shared.add_seed(parser)
    parser.add_argument(
        "--without",
        type=_left_out,
        default=frozenset(),
        metavar="LIST",
        help=f"leave out, separated by commas: {', '.join(STAGES_TO_LEAVE_OUT)}",
    )
    parser.add_argument(
        "--motor",
        type=_motor,
        default="playback",
        metavar="MOTOR",
        help="playback, or dynamics: every fish with muscles is simulated (default playback)",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the report there")
    parser.add_argument(
        "--compare",
        type=Path,
        metavar="FILE",
        help="compare with an older report of --json: how many times faster",
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the times of every frame")
    parser.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="plot the times of every frame as PNG (needs matplotlib: subsea[plot])",
    )
    parser.add_argument(
        "--paper", action="store_true", help="tables 3 and 4 of the 1999 paper for this machine"
    )
    parser.set_defaults(run=run)


def _fish_counts(text: str) -> tuple[int, ...]:
    one = number_reader(int, 1, 100_000)
    counts = tuple(int(one(part.strip())) for part in text.split(","))
    if len(set(counts)) < len(counts):
        raise ArgumentTypeError(f"{text!r}: expected every number once")
    return counts


def _motor(text: str) -> str:
    if text not in MOTORS:
        raise unknown("motor", text, list(MOTORS))
    return text


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
        from subsea.profiling.paper_tables import paper_tables

        return paper_tables()
    from subsea.profiling.benchmark import BenchmarkOptions, benchmark

    shared.check_display_without_window(options.display)
    shared.check_target(options)
    shared.settle_size(options)
    return benchmark(
        BenchmarkOptions(
            scenario=options.scenario,
            changes=options.changes,
            seed=options.seed,
            fish=options.fish or (None,),
            motor=options.motor,
            tour=options.tour,
            frames=options.frames,
            without=options.without,
            display=options.display,
            size=options.size,
            theatre=options.theatre,
            shrink=options.shrink,
            quality=options.quality,
            target_ms=options.target_ms,
            json=options.json,
            compare=options.compare,
            csv=options.csv,
            plot=options.plot,
        )
    )
