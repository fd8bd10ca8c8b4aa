"""`subsea-capture learn`: find the motor controllers of a species."""

import argparse
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command, number_reader


def add_to(commands: Any) -> None:
    """Add the command to the program."""
    parser = add_command(
        commands,
        "learn",
        "find the motor controllers of a species' body",
        "Optimises the tables [swim] and [turn] of a species file for speed, economy, a straight\n"
        "course and exact turns. The winner is verified for longer and under disturbances, then\n"
        "written to the file; nothing else in it changes. Exit code 0 if better controllers were\n"
        "found, 1 if not: then nothing is written. Needs cma and scipy (subsea[learn]).",
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
        help="evaluations of each search (300)",
    )
    parser.add_argument(
        "--seed",
        metavar="N",
        type=number_reader(int, 0, 2**31),
        default=1,
        help="the same seed gives the same result (1)",
    )
    parser.add_argument(
        "--ticks", metavar="N", type=number_reader(int, 4, 60), help="fix the ticks of a beat"
    )
    parser.add_argument(
        "--economy",
        metavar="W",
        type=number_reader(float, 0, 10),
        default=0.1,
        help="weight of economy relative to speed (0.1)",
    )
    parser.add_argument(
        "--out", metavar="FILE", type=Path, help="species file to write (default: the one read)"
    )
    parser.add_argument("--dry-run", action="store_true", help="write nothing")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.learning.improve import improve_species

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
