"""`subsea-capture fit`: make a fish that swims from a side outline."""

import argparse
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError

GROUP = "learn to swim"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "fit",
        "make a fish that swims from a side outline",
        "Fits the scaffold to the outline: rings, masses and a material that stays stable. Then\n"
        "searches gaits and turns, checks them and writes the species file. An outline is a TOML\n"
        "file with points around the fish; a species is fitted to the outline that it has. Exit\n"
        "code 1 if no gait was found. Needs the extra `learn`.",
        [
            "subsea-capture fit tuna.toml --name yellowfin_tuna --length 120",
            "subsea-capture fit tuna.toml --name yellowfin_tuna --length 120 --mass 27000 --record",
            "subsea-capture fit plaice.toml --name plaice --form flatfish --record",
            "subsea-capture fit my_fish",
        ],
    )
    parser.add_argument(
        "source", metavar="FILE", help="outline, or a species (a name, or the path of its file)"
    )
    parser.add_argument(
        "--name", metavar="NAME", help="new species, among your own (default: the species itself)"
    )
    parser.add_argument(
        "--length",
        metavar="CM",
        type=number_reader(float, 2, 300),
        help="length of an adult, of an outline",
    )
    parser.add_argument(
        "--mass",
        metavar="G",
        type=number_reader(float, 0.01, 1_000_000),
        help="mass at that length, which gives the width (default: a usual width)",
    )
    parser.add_argument(
        "--form",
        choices=["fish", "flatfish", "boxfish"],
        help="a fish that bends (default), one that lies on its side, or a stiff one that rows",
    )
    parser.add_argument(
        "--record", action="store_true", help="then record its motion, for scenarios"
    )
    parser.add_argument(
        "--budget",
        metavar="N",
        type=number_reader(int, 50, 1_000_000),
        default=800,
        help="evaluations of the search for body and fast gait (default 800)",
    )
    parser.add_argument(
        "--seed",
        metavar="N",
        type=number_reader(int, 0, 2**31),
        default=1,
        help="seed of the search (default 1)",
    )
    parser.add_argument("--out", metavar="PATH", type=Path, help="species file to write")
    parser.add_argument("--dry-run", action="store_true", help="write nothing")
    parser.add_argument(
        "--progress", action="store_true", help="show progress even without a terminal"
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.learning.fit import FitRequest, fit_species

    if options.record and (options.out or options.dry_run):
        raise UserError("--record needs a species among your own: leave out --out and --dry-run")
    request = FitRequest(
        source=options.source,
        name=options.name,
        out=options.out,
        length_cm=options.length,
        mass_g=options.mass,
        form=options.form,
        budget=options.budget,
        seed=options.seed,
        dry_run=options.dry_run,
        force=options.force,
        progress=options.progress,
    )
    found = fit_species(request)
    if found is None:
        return 1
    if options.record:
        from capture.cli.record import folder_of, record
        from capture.recording.batch import process_pool

        record(
            {found.stem: folder_of(found.stem)}, process_pool(1), options.progress, options.force
        )
        print(f"subsea dive --scenario peaceful --set fish.1.species={found.stem}")
    return 0
