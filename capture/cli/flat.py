"""`subsea-capture flat`: the two-dimensional fish of KS, which learns to swim."""

import argparse
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError

GROUP = "learn to swim"  # in the help
PARTS = ("body", "integrators", "learning", "swims", "turns", "switching", "folding")
FILMS = ("explosion", "swim", "goal")


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "flat",
        "teach the flat fish of Kobashi and Snavely to swim",
        "Simulates a fish in the plane, whose muscles learn to swim and to turn by annealing, and\n"
        "prints the numbers of each experiment. Takes five minutes, with --quick seconds. A\n"
        "scaffold of your own has other points, edges and muscles. Plots and films need the extra\n"
        "`plot`.",
        [
            "subsea-capture flat --quick",
            "subsea-capture flat --only learning --only swims --plots plots --films films",
            "subsea-capture flat --write-scaffold my_flat_fish.toml",
            "subsea-capture flat --scaffold my_flat_fish.toml --only swims --films films",
        ],
    )
    parser.add_argument(
        "--only", choices=PARTS, action="append", help="this experiment (repeatable; default all)"
    )
    parser.add_argument("--quick", action="store_true", help="learn little, in seconds")
    parser.add_argument(
        "--seed",
        metavar="N",
        type=number_reader(int, 0, 2**31),
        default=1,
        help="first seed of the searches (default 1)",
    )
    parser.add_argument("--plots", metavar="DIR", type=Path, help="folder for plots (PNG)")
    parser.add_argument(
        "--films",
        metavar="DIR",
        type=Path,
        help="folder for films (MP4): the explosion, the swim before and after, the way to a goal",
    )
    parser.add_argument(
        "--scaffold", metavar="FILE", type=Path, help="points and edges (.toml; default KS's fish)"
    )
    parser.add_argument(
        "--write-scaffold", metavar="FILE", type=Path, help="only write those of KS's fish, to edit"
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from subsea.base.file_kinds import FILM, check_results
    from subsea.base.files import check_folder
    from subsea.base.progress import print_line
    from subsea.base.report_files import check_plots, write_plots

    if options.write_scaffold:
        return _write_scaffold(options)
    from capture.flat.experiments import EXPERIMENTS
    from capture.flat.films import write_film
    from capture.flat.lessons import QUICK, Effort, FlatLearner
    from capture.flat.scaffold import KS_FISH, read_scaffold
    from subsea.base.system import require

    body = read_scaffold(options.scaffold or KS_FISH)
    learner = FlatLearner(body, QUICK if options.quick else Effort(), options.seed)
    parts = list(dict.fromkeys(options.only or PARTS))
    films = {name: options.films / f"flat_{name}.mp4" for name in FILMS if options.films}
    if options.plots:
        check_plots(options.plots, [f"flat_{name}.png" for name in parts], options.force)
    if films:
        require("plot", "films")
        check_folder(options.films)
        check_results(films.values(), FILM, options.force)
    drawn = {}
    for name in parts:
        lines, drawn[f"flat_{name}.png"] = EXPERIMENTS[name](learner)
        print("\n".join(lines), flush=True)
    for path in write_plots(options.plots, drawn) if options.plots else []:
        print_line(path)
    for name, path in films.items():
        write_film(learner, name, path)
        print_line(path)
    return 0


def _write_scaffold(options: argparse.Namespace) -> int:
    from capture.flat.scaffold import KS_FISH
    from subsea.base.file_kinds import check_result, toml_file
    from subsea.base.files import replacing
    from subsea.base.progress import print_line

    if options.scaffold:
        raise UserError("--scaffold and --write-scaffold: give one of the two")
    kind = toml_file("a scaffold", "points", "muscles")
    check_result(options.write_scaffold, kind, options.force)
    with replacing(options.write_scaffold) as temporary:
        temporary.write_bytes(KS_FISH.read_bytes())
    print_line(options.write_scaffold)
    return 0
