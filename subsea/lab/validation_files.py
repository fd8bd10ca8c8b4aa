"""Results of `subsea study --validate`: the report of all runs."""

from collections.abc import Sequence

from subsea.base.console import count_noun
from subsea.base.errors import UserError
from subsea.base.report_files import Report, ReportFiles
from subsea.fish.measured import load_measured
from subsea.jobs.workers import Check, Pool
from subsea.lab.validation import SeaTrial, run_trials
from subsea.lab.validation_plots import validation_plots
from subsea.lab.validation_report import findings, samples, summarise
from subsea.world.world import TICK_S

MAX_NAMED = 5  # crashed runs that an error names


def validate(jobs: Sequence[SeaTrial], files: ReportFiles, pool: Pool[int], check: Check) -> None:
    """Run trials, print the table and write the files; UserError at the end if runs crashed.

    `check` is called meanwhile and may raise; then nothing is written.
    """
    table = load_measured()
    done, crashed = run_trials(jobs, pool, check)
    found = summarise(done)
    seeds = sorted({trial.seed for trial, _ in done})
    seconds = max((trial.ticks for trial, _ in done), default=0) * TICK_S
    report = Report(
        findings(done, table),
        table.sources,
        extent=f"Seeds {seed_words(seeds)}, {seconds:.0f} s each.",
        more={"seeds": seeds, "seconds": round(seconds, 3), **samples(found)},
        plots=validation_plots(found, table),
    )
    files.write(report, check)
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
