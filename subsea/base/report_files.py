"""Results of a command that compares with measured fishes: table, page, JSON and PNG plots."""

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from subsea.base.file_kinds import PICTURE, check_result, check_results
from subsea.base.files import check_folder, replacing
from subsea.base.findings import (
    REPORT,
    RangeCheck,
    check_page,
    report_lines,
    summary,
    text_table,
    to_json,
    write_page,
)
from subsea.base.progress import print_line
from subsea.base.system import require

DPI = 100
STYLE: dict[str, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 8,
}

Draw = Callable[[Any], object]  # on an empty matplotlib figure


def check_plots(folder: Path, names: Iterable[str], force: bool) -> None:
    """Raise a UserError before any work if plots of these names cannot be written."""
    require("plot", "plots")
    check_folder(folder)
    check_results([folder / name for name in names], PICTURE, force)


def write_plots(
    folder: Path,
    pages: Mapping[str, Draw],
    check: Callable[[], object] = lambda: None,
    style: dict[str, Any] = STYLE,
) -> list[Path]:
    """Draw a page for each name and return the files; UserError without matplotlib.

    `check`, which may raise, is called before each page and before the files are renamed.
    """
    require("plot", "plots")
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    written = []
    with rc_context(style), ExitStack() as whole:
        for name, draw in pages.items():
            check()
            page = Figure(dpi=DPI, layout="constrained")
            draw(page)
            temporary = whole.enter_context(replacing(folder / name))
            page.savefig(temporary, format="png", metadata={"Software": None})
            written.append(folder / name)
        check()
    return written


@dataclass(frozen=True)
class Report:
    """Findings with what stands beside them."""

    findings: Sequence[RangeCheck]
    sources: Mapping[str, str]  # by the keys that findings name
    extent: str = ""  # a sentence above the table of a page
    more: Mapping[str, Any] = field(default_factory=dict)  # beside the findings in JSON
    plots: Mapping[str, Draw] = field(default_factory=dict)  # by name of the file
    below: Sequence[str] = ()  # lines of a page below the table


@dataclass(frozen=True)
class ReportFiles:
    """The files that a command writes, None for each that is not wanted."""

    name: str  # of the command; marks its part of a page
    json: Path | None = None
    page: Path | None = None
    plots: Path | None = None  # a folder

    def check(self, plots: Iterable[str], force: bool) -> None:
        """Raise a UserError before any work if one of the files cannot be written."""
        if self.json:
            check_result(self.json, REPORT, force)
        if self.page:
            check_page(self.page, self.name, force)
        if self.plots:
            check_plots(self.plots, plots, force)

    def write(self, report: Report, check: Callable[[], object] = lambda: None) -> None:
        """Write the files, and print the table and the names of the plots.

        `check`, which may raise, is called between two plots; then nothing is written.
        """
        rows = report.findings
        drawn = write_plots(self.plots, report.plots, check) if self.plots else []
        print("\n".join([*text_table(rows), "", summary(rows)]))
        if self.json:
            with replacing(self.json) as temporary:
                temporary.write_text(to_json(rows, **report.more), encoding="utf-8")
        if self.page:
            extent = [report.extent, ""] if report.extent else []
            below = ["", *report.below] if report.below else []
            write_page(self.page, self.name, [*extent, *report_lines(rows, report.sources), *below])
        for path in drawn:
            print_line(path)


def add_report_options(parser: argparse._ActionsContainer) -> None:
    """Add `--plots` and `--report`, whose meaning all such commands share."""
    parser.add_argument("--plots", metavar="DIR", type=Path, help="folder for plots (PNG)")
    parser.add_argument(
        "--report", metavar="FILE.md", type=Path,
        help="page for the table; text outside its marks is kept",
    )  # fmt: skip
