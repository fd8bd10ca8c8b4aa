"""Record a species' repertoire: its three swims and four turns (SMC §4.3)."""

import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import get_context
from typing import Any, NamedTuple

import msgspec
import numba
import numpy as np

from capture.segment import make_segment
from capture.skin import surface_coupling
from capture.trial import STRAIGHT, Trial, beat_contraction, sharp_turn, steady_beat
from subsea.biomechanics.body import Body, Floats, build_body
from subsea.biomechanics.controllers import LEFT, RIGHT
from subsea.biomechanics.plan import BodyPlan, SwimPlan, TurnPlan
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, TICK_S, TIME_UNIT_S
from subsea.repertoire import SEGMENTS, Repertoire, Segment
from subsea.species import Species, load_species


class Motion(NamedTuple):
    """The three plans that decide how a species moves."""

    body: BodyPlan
    swim: SwimPlan
    turn: TurnPlan


def steady_contraction(motion: Motion, name: str) -> Floats:
    """Contractions (6 T, 12) of one beat of a swim or gradual turn, or of that before a sharp turn.

    ``name`` is a segment's, such as ``turn_left_gradual``.
    """
    swim = motion.swim
    kind, _, grade = name.rpartition("_")
    if kind == "swim":
        return beat_contraction(swim, {"slow": swim.slow, "medium": swim.medium}.get(grade, 1.0))
    bias = motion.turn.gradual if grade == "gradual" else STRAIGHT
    return beat_contraction(swim, swim.medium, bias, side_of(name))


def side_of(name: str) -> float:
    """LEFT or RIGHT, the side of a turn's segment."""
    return LEFT if "left" in name else RIGHT


def run_trial(motion: Motion, name: str) -> Trial:
    """The trial behind the segment ``name``."""
    body = build_body(motion.body)
    trial = steady_beat(body, steady_contraction(motion, name))
    if not name.endswith("sharp"):
        return trial
    turn = motion.turn
    turned = sharp_turn(body, motion.swim, turn, turn.sharp, side_of(name), trial.state)
    return turned._replace(warm_up_beats=trial.warm_up_beats)


def record_segment(species: Species, name: str) -> tuple[Segment, int]:
    """One segment of a species' repertoire, and its warm-up in beats.

    Only schooling species carry control points: they are many, and SMC §4.1 trades the memory
    for them alone.
    """
    trial = run_trial(motion_of(species), name)
    kind, _, grade = name.rpartition("_")
    segment = make_segment(
        trial.frames,
        species.body.length,
        pattern={"swim": "forward", "turn_left": "left", "turn_right": "right"}[kind],
        grade=grade,
        cyclic=grade != "sharp",
        coupling=surface_coupling(species) if species.schooling else None,
    )
    return segment, trial.warm_up_beats


def motion_of(species: Species) -> Motion:
    """The plans of a species that the recording depends on."""
    return Motion(species.body, species.swim, species.turn)


def motion_from_provenance(provenance: dict[str, Any]) -> Motion:
    """The plans a repertoire was recorded from; msgspec.ValidationError where they are no plans."""
    return Motion(
        msgspec.convert(provenance.get("body"), BodyPlan),
        msgspec.convert(provenance.get("swim"), SwimPlan),
        msgspec.convert(provenance.get("turn"), TurnPlan),
    )


def assemble(name: str, species: Species, recorded: dict[str, tuple[Segment, int]]) -> Repertoire:
    """Put recorded segments together; the provenance holds all it takes to record them again."""
    body: Body = build_body(species.body)
    motion = motion_of(species)
    return Repertoire(
        species=name,
        tick_s=TICK_S,
        body_length_cm=species.body.length,
        source="biomechanics",
        provenance={
            "tool": "subsea-capture",
            "versions": {
                "subsea": _own_version(),
                "numpy": np.__version__,
                "numba": numba.__version__,
            },
            "seed": None,  # nothing in a recording is random
            "step_tu": STEP,
            "steps_per_tick": STEPS_PER_TICK,
            "time_unit_s": TIME_UNIT_S,
            "warm_up_beats": {segment: beats for segment, (_, beats) in sorted(recorded.items())},
            **{key: msgspec.to_builtins(plan) for key, plan in motion._asdict().items()},
        },
        rest_nodes=body.rest,
        segments={segment: recorded[segment][0] for segment in SEGMENTS},
    )


def _own_version() -> str:
    try:
        return version("subsea")
    except PackageNotFoundError:  # run from a checkout that is not installed
        return "checkout"


def record_all(
    names: list[str], jobs: int, finished: Callable[[str], object]
) -> Iterator[tuple[str, Repertoire]]:
    """Record several species and yield each name with its repertoire as soon as it is whole.

    ``finished(species)`` is called after each segment. With ``jobs`` above 1 segments
    are recorded in that many processes; the result is the same.
    """
    species = {name: load_species(name) for name in names}
    done: dict[str, dict[str, tuple[Segment, int]]] = {name: {} for name in names}
    with _workers(jobs) as run:
        for name, segment, result in run(species):
            done[name][segment] = result
            finished(name)
            if len(done[name]) == len(SEGMENTS):
                yield name, assemble(name, species[name], done.pop(name))


Results = Iterator[tuple[str, str, tuple[Segment, int]]]


@contextmanager
def _workers(jobs: int) -> Iterator[Callable[[dict[str, Species]], Results]]:
    """A function that records all segments of several species, here or in other processes."""
    if jobs == 1:
        yield _record_here
        return
    # Workers leave Ctrl-C to the main process, which then calls them off.
    pool = ProcessPoolExecutor(jobs, get_context("spawn"), signal.signal, _IGNORE)
    try:
        yield lambda species: _record_in(pool, species)
    finally:
        pool.shutdown(cancel_futures=True)


_IGNORE = (signal.SIGINT, signal.SIG_IGN)


def _record_here(species: dict[str, Species]) -> Results:
    for name, one in species.items():
        for segment in SEGMENTS:
            yield name, segment, record_segment(one, segment)


def _record_in(pool: ProcessPoolExecutor, species: dict[str, Species]) -> Results:
    tasks = {
        pool.submit(record_segment, one, segment): (name, segment)
        for name, one in species.items()
        for segment in SEGMENTS
    }
    for task in as_completed(tasks):
        yield *tasks[task], task.result()
