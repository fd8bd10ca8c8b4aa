"""Learn a species' body and gaits against those of real fishes, then its turns.

One search finds material, distribution of mass and the fast gait together (body_space.py,
lifelike.py). Amplitudes of the other grades follow from measured tail amplitudes (grades.py), the
gradual turn from measured headings (turn.py). Candidates are verified, best first: the first that
closes its beats at all grades, burst included, is taken, else the first without a burst.
"""

from itertools import islice
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from capture.learning.body_space import (
    BODY_SIZE,
    SWIM_SIZE,
    body_at,
    gait_at,
    outline_volume,
    species_point,
)
from capture.learning.fitness import disturbed_faults
from capture.learning.journal import Journal
from capture.learning.lifelike import HALF, POOR, grade_waves, wave_loss, with_amplitudes
from capture.learning.search import SPREAD, distinct, search
from capture.learning.turn import with_gradual
from capture.recording.fingerprint import fingerprint
from subsea.base.errors import UserError
from subsea.biomechanics.body import Body, Floats, build_body
from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan
from subsea.biomechanics.trial import displacement, grade_contraction, steady_beat
from subsea.fish.species import Species

ROOT = "capture.learning.whole"
LEAST_RATIO = 1.05  # of the speeds of neighbouring grades
MAX_VERIFIED = 24  # most candidates that are verified: few of the best close their beat and burst
NEARBY = 0.07  # first steps of a search that begins at a sound gait


class LearningTask(NamedTuple):
    """A species to learn, and the options of the search."""

    name: str
    species: Species
    body: bool  # search the body too
    budget: int  # evaluations of the search for gaits
    seed: int
    journal: Path


class Learned(NamedTuple):
    """The plans that were found, None without; and the reasons for which others were rejected."""

    muscles: Muscles | None
    notes: list[str]


def key_of(task: LearningTask) -> str:
    """Identify what the losses of a task depend on: the species, the program and the search."""
    return f"{fingerprint(task.species, ROOT)} body={task.body:d} seed={task.seed}"


def learn_whole(task: LearningTask) -> Learned:
    """Search, verify and return the plans; an interrupted search continues from its journal."""
    journal, notes = Journal(task.journal, key_of(task)), list[str]()
    try:
        return Learned(_learn(task, journal, notes), notes)
    finally:
        journal.save()


def _learn(task: LearningTask, journal: Journal, notes: list[str]) -> Muscles | None:
    muscles = task.species.muscles
    assert muscles
    volume = outline_volume(task.species.surface, muscles.body.length)
    size = SWIM_SIZE + BODY_SIZE if task.body else SWIM_SIZE

    def at(point: Floats | tuple[float, ...]) -> tuple[BodyPlan, SwimPlan]:
        place = np.asarray(point)
        plan = muscles.body
        if task.body:
            plan = body_at(plan, place[SWIM_SIZE:], volume)
        return plan, gait_at(plan, muscles.swim, place[:SWIM_SIZE])

    def loss(point: Floats) -> float:
        plan, swim = at(point)
        return wave_loss(build_body(plan), swim, task.seed)

    own, firm = (
        species_point(muscles.body, muscles.swim, volume, firm)[:size] for firm in (False, True)
    )
    remembered = journal.remembered(loss)
    first = remembered(own)
    known = first < POOR  # a species that was learned before
    start, spread, budget = (own, NEARBY, task.budget) if known else (firm, SPREAD, task.budget - 1)

    def again(point: Floats) -> float:
        return first if known and np.array_equal(point, own) else remembered(point)

    tried = search(again, start, "cma", budget, task.seed, spread=spread)
    kept = None
    for one in islice(distinct(tried), MAX_VERIFIED):
        found = _verified(task, at(one.point), kept is not None, notes)
        if found and found.swim.burst is not None:
            return found
        kept = kept or found
    return kept


def _verified(
    task: LearningTask, found: tuple[BodyPlan, SwimPlan], bursts: bool, notes: list[str]
) -> Muscles | None:
    """Body and gait with all grades and turns, if they pass the verification.

    With ``bursts`` a burst must be among them.
    """
    plan, swim = found
    body = build_body(plan)
    try:
        swim = _with_fit_burst(body, with_amplitudes(body, swim))
        faults = ["it has no burst"] if bursts and swim.burst is None else []
        faults = faults or whole_faults(body, swim, task.seed)
    except (UserError, ValueError) as fault:
        faults = [str(fault)]
    if faults:
        notes.append(f"gait: rejected: {faults[0]}")
        return None
    assert task.species.turn
    # Sharp turns are the widest of the steering map: recording finds how to make them.
    turn = msgspec.structs.replace(task.species.turn, sharp=task.species.turn.steering[-1].angle)
    try:
        return Muscles(plan, swim, with_gradual(body, swim, turn))
    except UserError as fault:
        notes.append(f"turn: rejected: {fault}")
        return None


def _with_fit_burst(body: Body, swim: SwimPlan) -> SwimPlan:
    """The plan without its burst, if the body cannot close it or it is hardly faster than fast.

    Playback then bursts with the fast swim at a higher tempo.
    """
    try:
        fast, burst = (_speed(body, swim, grade) for grade in ("fast", "burst"))
    except UserError:
        burst = fast = 1.0
    if burst >= LEAST_RATIO * fast:
        return swim
    return msgspec.structs.replace(swim, burst=None, burst_ticks=None)


def _speed(body: Body, swim: SwimPlan, grade: str) -> float:
    """Speed of a steady grade, cm a tick."""
    frames = steady_beat(body, grade_contraction(swim, grade)).frames
    return float(np.linalg.norm(displacement(frames))) / (len(frames) - 1)


def whole_faults(body: Body, swim: SwimPlan, seed: int) -> list[str]:
    """Verify that a gait can be recorded and withstands disturbances; UserError for a lost shape.

    The aims of its fast grade are not checked: the best that was found is what a body can do.
    """
    for grade, wave in grade_waves(body, swim).items():
        if np.isinf(wave.wavelength):
            return [f"no wave runs to its tail at grade {grade}"]
    speeds = [_speed(body, swim, grade) for grade in swim.grades]
    for name, below, speed in zip(swim.grades[1:], speeds[:-1], speeds[1:], strict=True):
        if speed < LEAST_RATIO * below:
            return [f"{name} is only {speed / below:.2f} times as fast as the grade below"]
    graded = [(swim.at(grade), swim.amplitude(grade)) for grade in swim.grades]
    return disturbed_faults(body, [*graded, (swim, HALF)], seed)
