"""`subsea-capture learn`: find the motor controllers of a species."""

import argparse
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command, add_force, number_reader


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "learn",
        "find the motor controllers of a species' body",
        "Optimises the tables [swim] and [turn] of a species file for speed, economy, a straight\n"
        "course and exact turns. The result is verified under disturbances, then written. Exit\n"
        "code 1 if nothing better was found; then nothing is written. Needs the extra `learn`.",
        [
            "subsea-capture learn fusilier",
            "subsea-capture learn fusilier --only turn --dry-run",
            "subsea-capture learn my_fish.toml --method annealing --out /tmp/my_fish.toml",
        ],
    )
    parser.add_argument("species", metavar="SPECIES", help="species, or path of its .toml file")
    parser.add_argument(
        "--only", choices=["swim", "turn"], default="", help="learn this table only"
    )
    parser.add_argument(
        "--method",
        choices=["cma", "annealing"],
        default="cma",
        help="CMA-ES (default) or simulated annealing",
    )
    parser.add_argument(
        "--budget",
        metavar="N",
        type=number_reader(int, 1, 1_000_000),
        default=300,
        help="evaluations of each search (default 300)",
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
        default=0.1,
        help="weight of economy relative to speed (default 0.1)",
    )
    parser.add_argument(
        "--out", metavar="FILE", type=Path, help="species file to write (default: the one read)"
    )
    parser.add_argument("--dry-run", action="store_true", help="write nothing")
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.learning.improve import improve_species
    from subsea.core.file_kinds import check_result, toml_file

    if options.out is not None and not options.dry_run:
        check_result(options.out, toml_file("a species", "surface", "skin"), options.force)

    return improve_species(
        options.species,
        options.out,
        options.dry_run,
        options.budget,
        only=options.only,
        method=options.method,
        seed=options.seed,
        ticks=options.ticks,
        economy=options.economy,
    )
