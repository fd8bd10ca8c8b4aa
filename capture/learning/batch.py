"""Learn several species in parallel processes and write their files.

The journal of a species, ``.SPECIES.learning`` beside the file to write, has its finished
evaluations, and its result once that is written. All journals are removed when every species of the
command is done.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from tqdm import tqdm

from capture.learning.improve import faults_of, other_faults, writable_source, write_plans
from capture.learning.journal import evaluations, read_journal, write_journal
from capture.learning.lifelike import grade_waves, missed_aims
from capture.learning.whole import ROOT, Learned, LearningTask, learn_whole
from capture.recording.fingerprint import fingerprint
from subsea.base.errors import UserError
from subsea.base.file_kinds import check_results, toml_file
from subsea.base.interrupts import deferred_interrupts
from subsea.base.system import require
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import build_body
from subsea.biomechanics.solver import TICK_S
from subsea.fish.species import Species, shipped_species, species_file
from subsea.jobs.workers import MAX_ATTEMPTS, Check, Pool, process_pool
from subsea.repertoire.findings import complaints, try_motion


class Plan(NamedTuple):
    """A task with the species file that it reads and the one that it writes."""

    task: LearningTask
    source: Path
    target: Path | None  # None: write nothing


Progress = Callable[[str, int], object]  # name and finished evaluations


def learn_species(
    names: list[str] | None,
    out: Path | None,
    dry_run: bool,
    body: bool,
    budget: int,
    seed: int,
    jobs: int,
    force: bool,
) -> int:
    """Learn species (None: all shipped ones with muscles) and report; 0 if all were found, else 1.

    They are written to their own files or into the folder ``out``; with ``force`` journals are
    ignored and foreign files replaced.
    """
    require("learn", "learning")
    sources = [species_file(name) for name in names or shipped_species()]
    with TemporaryDirectory() as scratch:
        plans: dict[str, Plan] = {}
        for source in dict.fromkeys(sources):
            species = load_toml(source, Species)
            if species.muscles is None:
                if names is None:
                    continue
                raise UserError("driven by its spine; expected a species with muscles", file=source)
            if source.stem in plans:
                raise UserError(f"two species files have the name {source.stem}", file=source)
            target = out / source.name if out else writable_source(source, dry_run)
            journal = journal_path(Path(scratch) / source.name if dry_run else target)
            task = LearningTask(source.stem, species, body, budget, seed, journal)
            plans[source.stem] = Plan(task, source, None if dry_run else target)
        found = learn_plans(plans, jobs, dry_run, force)
    return 0 if found else 1


def learn_plans(
    plans: Mapping[str, Plan], jobs: int, dry_run: bool, force: bool, progress: bool = False
) -> bool:
    """Learn species in ``jobs`` processes, show progress and report; True if all were found.

    Bars are shown on a terminal, with ``progress`` always.
    """
    _prepare(plans, force)
    bars = {
        name: tqdm(
            total=plan.task.budget,
            desc=name,
            position=place,
            unit="try",
            disable=False if progress else None,
        )
        for place, (name, plan) in enumerate(plans.items())
    }

    def show(name: str, done: int) -> None:
        bar = bars[name]
        bar.total = max(bar.total or 0, done)
        bar.update(done - bar.n)

    def finish(name: str, learned: Learned) -> None:
        for line in report(name, learned):
            tqdm.write(line)

    try:
        with deferred_interrupts() as check:
            return learn_all(plans, process_pool(jobs), check, show, finish)
    except KeyboardInterrupt:
        why = "dry run: nothing is kept" if dry_run else "run the same command to continue"
        raise KeyboardInterrupt(why) from None
    finally:
        for bar in bars.values():
            bar.close()


def _prepare(plans: Mapping[str, Plan], force: bool) -> None:
    """Check that the files can be written, and with ``force`` remove journals."""
    targets = [plan.target for plan in plans.values() if plan.target is not None]
    check_results(targets, toml_file("a species", "surface", "skin"), force)
    for plan in plans.values():
        if force:
            with suppress(OSError):
                plan.task.journal.unlink()


def journal_path(target: Path) -> Path:
    """The journal of a species file."""
    return target.with_name(f".{target.stem}.learning")


def learn_all(
    plans: Mapping[str, Plan],
    pool: Pool[str],
    check: Check,
    progress: Progress,
    finish: Callable[[str, Learned], object],
) -> bool:
    """Learn and write the species; True if every one was found, then their journals are removed.

    Those that an interrupted run of the same command has finished are skipped. ``progress`` is
    called while they are learned, ``finish`` with each result after it is written.
    """
    waiting = {name: plan for name, plan in plans.items() if not is_done(plan)}

    def look() -> None:
        check()
        for name, plan in waiting.items():
            progress(name, evaluations(plan.task.journal))

    complete = True
    tasks = {name: plan.task for name, plan in waiting.items()}
    with closing(pool(learn_whole, tasks, look)) as results:
        for name, learned in results:
            if learned is None:
                raise UserError(f"worker processes crashed {MAX_ATTEMPTS} times in learning {name}")
            complete &= learned.muscles is not None
            progress(name, evaluations(plans[name].task.journal))
            if learned.muscles is not None:
                write_result(plans[name], learned)
            finish(name, learned)
    if complete:
        for plan in plans.values():
            with suppress(OSError):
                plan.task.journal.unlink()
    return complete


def write_result(plan: Plan, learned: Learned) -> None:
    """Write the species file, and into the journal that this is done."""
    if plan.target is None or learned.muscles is None:
        return
    write_plans(plan.source, plan.target, **learned.muscles._asdict())
    mark = _mark(plan.task, load_toml(plan.target, Species))
    write_journal(plan.task.journal, read_journal(plan.task.journal) | {"done": mark})


def is_done(plan: Plan) -> bool:
    """True if the target is the result of this task."""
    done = read_journal(plan.task.journal).get("done")
    if plan.target is None or done is None:
        return False
    try:
        return bool(done == _mark(plan.task, load_toml(plan.target, Species)))
    except UserError:
        return False


def _mark(task: LearningTask, written: Species) -> str:
    """Identify a written result and the options of the command."""
    return f"{fingerprint(written, ROOT)} {task.body:d} {task.budget} {task.seed}"


COLUMNS = (
    "ticks",
    "amplitude",
    "L/s",
    "stride, L",
    "tail, L",
    "Strouhal",
    "wave, L",
    "envelope, L",
)


def report(name: str, learned: Learned) -> Iterator[str]:
    """Lines: a table of the grades, and the aims that the fast one misses."""
    if learned.muscles is None:
        why = f", the last candidate as {learned.notes[-1]}" if learned.notes else ""
        faults = faults_of(learned.notes)
        why += other_faults(faults, faults[-1]) if faults else ""
        yield f"{name}: nothing was found{why}; the file is unchanged, try a larger --budget"
        return
    plan, swim, turn = learned.muscles
    body = build_body(plan)
    waves = grade_waves(body, swim)
    yield f"{name:<24}" + "".join(f"{column:>12}" for column in COLUMNS)
    for grade, wave in waves.items():
        ticks = swim.at(grade).ticks_per_beat
        speed = wave.stride / (ticks * TICK_S)
        values = (speed, wave.stride, wave.tail, wave.strouhal, wave.wavelength, wave.envelope)
        cells = f"{ticks:>12}{swim.amplitude(grade):>12.3f}"
        yield f"  {grade:<22}{cells}" + "".join(f"{value:>12.3f}" for value in values)
    yield f"  turns: {', '.join(f'{row.angle:g}°' for row in turn.steering)}, sharp {turn.sharp:g}°"
    missed = missed_aims(waves)
    if missed:
        yield f"  fast misses: {'; '.join(missed)}"
    for words in complaints(try_motion(learned.muscles)):
        yield f"  warning: {words}"
