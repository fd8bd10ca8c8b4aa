"""Improve the controllers of a species file: search, report, and write the numbers."""

import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
from tqdm import tqdm

from capture.inspection.gait import ENTRY_PHASES
from capture.learning.fitness import (
    HORIZON,
    STARTS,
    VERIFY_FACTOR,
    GaitMeasures,
    TurnMeasures,
    measure_gait,
    measure_turning,
)
from capture.learning.learn import LearnedControllers, learn
from subsea.base.errors import UserError
from subsea.base.files import check_file, read_text, replacing
from subsea.base.system import require, resource_path
from subsea.base.toml_edit import edit_toml
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import build_body
from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan, TurnPlan
from subsea.biomechanics.trial import beat_contraction, grade_contraction, steady_beat
from subsea.fish.species import SHIPPED, Species, species_file
from subsea.repertoire.findings import complaints, try_motion

NUMBER = re.compile(r"[-+]?\d[\d.]*")


def write_plans(source: Path, target: Path, **plans: BodyPlan | SwimPlan | TurnPlan) -> None:
    """Write a species file with other tables, such as ``swim``; comments and order are kept."""
    text = read_text(source)
    content = tomllib.loads(text)
    for name, plan in plans.items():
        old, new = content.get(name, {}), msgspec.to_builtins(plan)
        # Keys that the file omits and the plan has at their default stay omitted.
        defaults = {one.name: one.default for one in msgspec.structs.fields(plan)}
        kept = {key: value for key, value in new.items() if key in old or value != defaults[key]}
        left = {key: value for key, value in old.items() if key in new}
        text = edit_toml(text, old, left | kept, (name,), source)
    with replacing(target) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        written = load_toml(temporary, Species)
        if any(getattr(written, name) != plan for name, plan in plans.items()):
            tables = " and ".join(f"[{name}]" for name in plans)
            raise UserError(f"its tables {tables} cannot be edited", file=source)


def improve_species(name: str, out: Path | None, dry_run: bool, budget: int, **options: Any) -> int:
    """Learn the controllers of a species and write them; return 0, or 1 if none are better.

    ``options`` are those of :func:`capture.learning.learn.learn`. UserError before the search.
    """
    require("learn", "learning")
    source = species_file(name)
    species = load_toml(source, Species)
    muscles = species.muscles
    if muscles is None:
        raise UserError("driven by its spine; expected a species with muscles", file=source)
    target = out or writable_source(source)
    if not dry_run:
        check_file(target)
    best: dict[str, tuple[float, SwimPlan | TurnPlan]] = {}
    bars: dict[str, Any] = {}

    def show(stage: str, loss: float, plan: SwimPlan | TurnPlan) -> None:
        if stage not in bars:
            bars[stage] = tqdm(total=budget, desc=f"{source.stem}: {stage}", unit="try")
        elif bars[stage].n == bars[stage].total:
            bars[stage].total += budget  # for the next gait, if one cannot turn
        if stage not in best or loss < best[stage][0]:
            best[stage] = loss, plan
            bars[stage].set_postfix_str(f"best {loss:.4f}", refresh=False)
        bars[stage].update()

    try:
        found = learn(muscles, budget=budget, progress=show, **options)
    except KeyboardInterrupt:
        kept = [f"best {stage} so far, not verified: {best[stage][1]}" for stage in best]
        raise KeyboardInterrupt("; ".join([*kept, f"{target} is unchanged"])) from None
    finally:
        for bar in bars.values():
            bar.close()
    if found.swim is None and found.turn is None:
        tried = sum(bar.n for bar in bars.values())
        rejected = faults_of(found.notes)
        why = f", {len(rejected)} rejected, the best as {rejected[0]}" if rejected else ""
        others = other_faults(rejected, rejected[0]) if rejected else ""
        what = f"nothing better found in {tried} tries"
        print(f"{source.stem}: {what}{why}{others}; {target} is unchanged")
        return 1
    for note in found.notes:
        print(note)
    new: dict[str, Any] = {"swim": found.swim or muscles.swim, "turn": found.turn or muscles.turn}
    learned = muscles._replace(**new)
    for line in [*_comparison(muscles, learned), *_tables(learned), *_verification(found)]:
        print(line)
    for words in complaints(try_motion(learned)):
        print(f"warning: {words}")
    if dry_run:
        print(f"dry run: {target} is unchanged")
    else:
        write_plans(source, target, **new)
        print(f"{target} has new controllers; record it again with `subsea-capture record`")
    return 0


def faults_of(notes: list[str]) -> list[str]:
    """Select from the notes of learning why candidates were rejected, in the order of trial."""
    return [note.partition("rejected: ")[2] for note in notes if "rejected: " in note]


def other_faults(faults: list[str], told: str) -> str:
    """List the kinds of faults that differ from one by more than their numbers."""
    kinds = Counter(NUMBER.sub("…", fault) for fault in faults)
    kinds.pop(NUMBER.sub("…", told), None)
    words = ", ".join(f"{kind} ({count})" for kind, count in kinds.most_common())
    return f", others as {words}" if words else ""


def writable_source(source: Path, dry_run: bool = False) -> Path:
    """The file to write: the one read; UserError for one of an installed package."""
    shipped = source.parent == resource_path(SHIPPED)
    if shipped and not dry_run and not resource_path("pyproject.toml").is_file():
        raise UserError("name what to write: --out PATH")
    return source


def _comparison(old: Muscles, new: Muscles) -> Iterator[str]:
    """A table of old and new measures."""
    before, after = _values(old), _values(new)
    yield f"{'':<34} {'before':>18} {'after':>18}"
    for name in after:
        yield f"{name:<34} {before.get(name, '-'):>18} {after[name]:>18}"


def _verification(found: LearnedControllers) -> Iterator[str]:
    """A summary of the verification."""
    beats = round(VERIFY_FACTOR * HORIZON)
    if found.swim:
        swims = 4 * STARTS
        yield f"verified: {swims} disturbed swims of {beats} beats, ten amplitudes, three grades"
    if found.turn:
        rows = len(found.turn.steering)
        yield (
            f"verified: {rows} disturbed turns and {beats} beats after each, each from "
            f"{ENTRY_PHASES} phases, 180° to both sides, gradual turns to both sides"
        )


GAIT_ROWS = {
    "stride": ("fast swim, L a beat", ".3f"),
    "speed": ("fast swim, L/tu", ".4f"),
    "cost": ("work, J/(kg m)", ".4f"),
    "drift": ("drift of heading in 20 beats, °", ".4f"),
    "aside": ("drift aside meanwhile, L", ".1e"),
    "tail": ("tail sweep, L", ".3f"),
    "head": ("head sweep, L", ".3f"),
    "snout": ("bend of the snout, °", ".1f"),
    "strouhal": ("Strouhal number", ".3f"),
    "contraction_step": ("contraction a step, cm", ".4f"),
}
TURN_ROWS = {
    "ticks": ("widest turn, ticks", ".1f"),
    "kept": ("speed kept in it", ".3f"),
    "snout": ("bend of the snout in it, °", ".1f"),
    "contraction_step": ("contraction a step in it, cm", ".4f"),
}


def _values(muscles: Muscles) -> dict[str, str]:
    """Formatted measures by name, without those that the body cannot perform."""
    values = {}
    gait, turning = _gait(muscles), _turning(muscles)
    if gait is not None:
        values = {name: f"{getattr(gait, key):{form}}" for key, (name, form) in GAIT_ROWS.items()}
    if turning is not None:
        rows = muscles.turn.steering
        for row, error, worst in zip(rows, turning.errors, turning.worst, strict=True):
            values[f"turn of {row.angle:g}°, error and worst, °"] = f"{error:+.2f}, {worst:+.2f}"
        for key, (name, form) in TURN_ROWS.items():
            values[name] = f"{getattr(turning, key):{form}}"
    return values


def _gait(muscles: Muscles) -> GaitMeasures | None:
    """Measures of the steady fast gait; None where the body has none."""
    body = build_body(muscles.body)
    try:
        steady = steady_beat(body, beat_contraction(muscles.swim, 1.0)).state
    except UserError:
        return None
    return measure_gait(body, muscles.swim, 1.0, steady)


def _turning(muscles: Muscles) -> TurnMeasures | None:
    """Measures of sharp turns; None where the body loses its shape."""
    plan, swim, turn = muscles
    body = build_body(plan)
    try:
        steady = steady_beat(body, grade_contraction(swim, "medium")).state
        angles = [row.angle for row in turn.steering]
        return measure_turning(body, swim, turn, steady, angles)
    except UserError:
        return None


def _tables(muscles: Muscles) -> Iterator[str]:
    """A summary of the new tables."""
    _, swim, turn = muscles
    row, holds = turn.steering[-1], [row.hold_ticks for row in turn.steering]
    yield (
        f"swim: {swim.ticks_per_beat} ticks, contraction {list(swim.contraction)}, lag {swim.lag:g}"
        f", slow {swim.slow:g}, medium {swim.medium:g}"
    )
    yield (
        f"turn: contraction {list(row.contraction)}, bend {row.bend_ticks:g}, restore "
        f"{row.restore_ticks:g}, holds {holds} ticks, amplitude {turn.amplitude:g}, "
        f"gradual {list(turn.gradual)}"
    )
