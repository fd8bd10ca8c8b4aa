"""Results of `subsea study --validate`: the table, a page, JSON and plots."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from subsea.core.atomic_io import check_folder, replacing
from subsea.core.console import count_noun
from subsea.core.errors import UserError
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
from subsea.core.workers import Check, Pool
from subsea.fish.measured import load_measured
from subsea.study.plots import check_plots
from subsea.study.validation import SeaTrial, run_trials
from subsea.study.validation_plots import plot_validation, validation_plots_in
from subsea.study.validation_report import findings, samples, summarise
from subsea.world.world import TICK_S

MAX_NAMED = 5  # crashed runs that an error names


@dataclass(frozen=True)
class ValidationFiles:
    """The files to write, None for each that is not wanted."""

    json: Path | None = None
    page: Path | None = None
    plots: Path | None = None

    def check(self, name: str, force: bool) -> None:
        """Raise a UserError before any work if one of the files cannot be written."""
        if self.json:
            check_result(self.json, REPORT, force)
        if self.page:
            check_page(self.page, name, force)
        if self.plots:
            check_folder(self.plots)
            check_results(validation_plots_in(self.plots), PICTURE, force)
            check_plots()


def validate(
    jobs: Sequence[SeaTrial], files: ValidationFiles, name: str, pool: Pool[int], check: Check
) -> None:
    """Run trials, print the table and write the files; UserError at the end if runs crashed.

    `name` marks the part of the page. `check` is called meanwhile and may raise; then nothing is
    written.
    """
    table = load_measured()
    done, crashed = run_trials(jobs, pool, check)
    rows = findings(done, table)
    found = summarise(done)
    seeds = sorted({trial.seed for trial, _ in done})
    seconds = max((trial.ticks for trial, _ in done), default=0) * TICK_S
    print("\n".join([*text_table(rows), "", summary(rows)]))
    if files.json:
        more = {"seeds": seeds, "seconds": round(seconds, 3), **samples(found)}
        with replacing(files.json) as temporary:
            temporary.write_text(to_json(rows, **more), encoding="utf-8")
    if files.page:
        extent = f"Seeds {seed_words(seeds)}, {seconds:.0f} s each."
        write_page(files.page, name, [extent, "", *report_lines(rows, table.sources)])
    drawn = plot_validation(found, table, files.plots, check) if files.plots else []
    for path in drawn:
        print(path)
    if crashed:
        named = "; ".join(f"{trial.label}, seed {trial.seed}" for trial in crashed[:MAX_NAMED])
        raise UserError(
            f"without {count_noun(len(crashed), 'run', 'runs')} whose process crashed ({named}); "
            "is there enough memory?"
        )


def seed_words(seeds: Sequence[int]) -> str:
    """Seeds in words: ``1 to 20`` or ``1, 5, 9``."""
    if len(seeds) > 2 and list(seeds) == list(range(seeds[0], seeds[-1] + 1)):
        return f"{seeds[0]} to {seeds[-1]}"
    return ", ".join(map(str, seeds)) or "none"
