"""`subsea-capture validate`: compare repertoires with measured fishes."""

import argparse
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command, add_force

NAME = "subsea-capture validate"


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
    parser.add_argument("--plots", metavar="DIR", type=Path, help="folder for plots (PNG)")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the findings")
    parser.add_argument(
        "--report", metavar="FILE.md", type=Path,
        help="page for the table; text outside its marks is kept",
    )  # fmt: skip
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.inspection.validation import validate
    from capture.plots.validation import plot_validation, plots_in
    from subsea.core.atomic_io import check_folder, replacing
    from subsea.core.extras import require
    from subsea.core.file_kinds import PICTURE, check_result, check_results
    from subsea.core.findings import (
        REPORT,
        check_page,
        report_lines,
        summary,
        text_table,
        to_json,
        write_page,
    )
    from subsea.fish.measured import load_measured, measured_species
    from subsea.fish.species import load_species, repertoire_file
    from subsea.repertoire import read_repertoire

    table = load_measured()
    names = list(dict.fromkeys(options.species)) or list(table.species)
    for name in names:
        measured_species(table, name)
    if options.json:
        check_result(options.json, REPORT, options.force)
    if options.report:
        check_page(options.report, NAME, options.force)
    if options.plots:
        require("plot", "plots")
        check_folder(options.plots)
        check_results(plots_in(options.plots), PICTURE, options.force)
    found = [
        validate(read_repertoire(repertoire_file(name)), load_species(name), table)
        for name in names
    ]
    findings = [finding for one in found for finding in one.findings]
    print("\n".join([*text_table(findings), "", summary(findings)]))
    if options.json:
        with replacing(options.json) as temporary:
            temporary.write_text(to_json(findings), encoding="utf-8")
    if options.report:
        write_page(options.report, NAME, report_lines(findings, table.sources))
    for path in plot_validation(found, options.plots) if options.plots else []:
        print(path)
    return 0
