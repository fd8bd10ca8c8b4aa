"""`subsea-capture validate`: compare repertoires with measured fishes."""

import argparse
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force
from subsea.base.report_files import add_report_options

NAME = "subsea-capture validate"


GROUP = "record and measure"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "validate",
        "compare repertoires with measured fishes",
        "Prints a table: quantity, ours, published range, source, verdict. The measured fishes\n"
        "are in assets/swimming.toml. Plots need the extra `plot`.",
        [
            "subsea-capture validate",
            "subsea-capture validate fusilier moon_wrasse --plots plots --json swimming.json",
        ],
    )
    parser.add_argument(
        "species", metavar="SPECIES", nargs="*", help="shipped species (default: all of them)"
    )
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the findings")
    add_report_options(parser)
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.inspection.validation import validate
    from capture.plots.pages import SWIMMING_PLOTS, swimming_plots
    from subsea.base.report_files import Report, ReportFiles
    from subsea.fish.measured import load_measured, measured_species
    from subsea.fish.species import load_species, repertoire_file
    from subsea.repertoire import read_repertoire

    table = load_measured()
    names = list(dict.fromkeys(options.species)) or list(table.species)
    for name in names:
        measured_species(table, name)
    files = ReportFiles(NAME, options.json, options.report, options.plots)
    files.check(SWIMMING_PLOTS, options.force)
    found = [
        validate(read_repertoire(repertoire_file(name)), load_species(name), table)
        for name in names
    ]
    findings = [finding for one in found for finding in one.findings]
    files.write(Report(findings, table.sources, plots=swimming_plots(found)))
    return 0
