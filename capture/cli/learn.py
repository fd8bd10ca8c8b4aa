"""`subsea-capture learn`: find the motor controllers of a species."""

import argparse
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError

MAX_JOBS = 64


GROUP = "learn to swim"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "learn",
        "find the motor controllers of a species' body",
        "Optimises the tables [swim] and [turn] of a species file for speed, economy, a straight\n"
        "course and exact turns. The result is verified under disturbances, then written. Exit\n"
        "code 1 if nothing better was found; then nothing is written. Needs the extra `learn`.\n"
        "--body and --gait search bodies and gaits like those of real fishes, for several species\n"
        "at once; an interrupted run continues where it stopped.",
        [
            "subsea-capture learn fusilier",
            "subsea-capture learn fusilier --only turn --dry-run",
            "subsea-capture learn my_fish.toml --method annealing --out /tmp/my_fish.toml",
            "subsea-capture learn --body --gait --all --jobs 2",
        ],
    )
    parser.add_argument(
        "species", metavar="SPECIES", nargs="*", help="species, or paths of their .toml files"
    )
    parser.add_argument(
        "--gait",
        action="store_true",
        help="find lifelike gaits with a frequency for each grade, and their turns",
    )
    parser.add_argument(
        "--body", action="store_true", help="with them, find material and masses of the body"
    )
    parser.add_argument(
        "--all", action="store_true", help="with --body or --gait: all shipped species with muscles"
    )
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=number_reader(int, 1, MAX_JOBS),
        default=1,
        help="with --body or --gait: parallel processes (default 1)",
    )
    parser.add_argument(
        "--only", choices=["swim", "turn"], default="", help="learn this table only"
    )
    parser.add_argument(
        "--method",
        choices=["cma", "annealing"],
        help="CMA-ES (default) or simulated annealing",
    )
    parser.add_argument(
        "--budget",
        metavar="N",
        type=number_reader(int, 1, 1_000_000),
        help="evaluations of each search (default 300, with --body or --gait 4000)",
    )
    parser.add_argument(
        "--seed",
        metavar="N",
        type=number_reader(int, 0, 2**31),
        default=1,
        help="seed of the search (default 1)",
    )
    parser.add_argument(
        "--ticks",
        metavar="N",
        type=number_reader(int, 4, 60),
        help="fixed duration of a beat in ticks",
    )
    parser.add_argument(
        "--economy",
        metavar="W",
        type=number_reader(float, 0, 10),
        help="weight of economy relative to speed (default 0.1)",
    )
    parser.add_argument(
        "--out",
        metavar="PATH",
        type=Path,
        help="species file to write (default: the one read); with --body or --gait a folder",
    )
    parser.add_argument("--dry-run", action="store_true", help="write nothing")
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    if options.body or options.gait:
        return _learn_whole(options)
    if options.all or options.jobs != 1 or len(options.species) > 1:
        raise UserError("--all, --jobs and several species: give --body or --gait too")
    if not options.species:
        raise UserError("expected SPECIES: the name of one, or the path of its .toml file")
    return _learn_controllers(options)


def _learn_controllers(options: argparse.Namespace) -> int:
    from capture.learning.improve import improve_species
    from subsea.base.file_kinds import check_result, toml_file

    if options.out is not None and not options.dry_run:
        check_result(options.out, toml_file("a species", "surface", "skin"), options.force)

    return improve_species(
        options.species[0],
        options.out,
        options.dry_run,
        options.budget or 300,
        only=options.only,
        method=options.method or "cma",
        seed=options.seed,
        ticks=options.ticks,
        economy=0.1 if options.economy is None else options.economy,
    )


def _learn_whole(options: argparse.Namespace) -> int:
    from capture.learning.batch import learn_species

    for name in ("only", "method", "ticks", "economy"):
        if getattr(options, name) not in (None, ""):
            raise UserError(f"--{name} and --body or --gait: give one of the two")
    if options.all == bool(options.species):
        raise UserError("name species or give --all, one of the two")
    return learn_species(
        options.species or None,
        options.out,
        options.dry_run,
        body=options.body,
        budget=options.budget or 4000,
        seed=options.seed,
        jobs=options.jobs,
        force=options.force,
    )
