"""Learn a species' body and gaits against those of real fishes, then its turns.

One search finds material, distribution of mass and the fast gait together (body_space.py,
lifelike.py). Amplitudes of the other grades follow from measured tail amplitudes (grades.py), the
turn controllers from a second search (turn.py). Candidates are verified, best first.
"""

from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from capture.learning.body_space import (
    SWIM_SIZE,
    body_at,
    gait_at,
    outline_volume,
    species_point,
)
from capture.learning.fitness import disturbed_faults
from capture.learning.grades import with_amplitudes
from capture.learning.journal import Journal
from capture.learning.lifelike import HALF, wave_loss
from capture.learning.search import Evaluation, distinct, search
from capture.learning.swim import MAX_VERIFIED
from capture.learning.turn import refit_holds, verified_turn
from capture.recording.fingerprint import fingerprint
from capture.recording.trial import displacement, grade_contraction, steady_beat
from subsea.biomechanics.body import Body, Floats, build_body
from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan, TurnPlan
from subsea.core.errors import UserError
from subsea.fish.species import Species

ROOT = "capture.learning.whole"
TURN_SHARE = 0.04  # evaluations of the search for turns over those of the search for gaits
LEAST_TURNS = 4
LEAST_RATIO = 1.05  # of the speeds of neighbouring grades


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


def turn_budget(budget: int) -> int:
    """Evaluations of the search for turns."""
    return max(LEAST_TURNS, round(TURN_SHARE * budget))


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
    start = species_point(muscles.body, muscles.swim, volume)

    def at(point: Floats | tuple[float, ...]) -> tuple[BodyPlan, SwimPlan]:
        place = np.asarray(point)
        plan = muscles.body
        if task.body:
            plan = body_at(plan, place[SWIM_SIZE:], volume)
        return plan, gait_at(plan, muscles.swim, place[:SWIM_SIZE])

    def loss(point: Floats) -> float:
        plan, swim = at(point)
        return wave_loss(build_body(plan), swim, task.seed)

    size = len(start) if task.body else SWIM_SIZE
    tried = search(journal.remembered(loss), start[:size], "cma", task.budget, task.seed)
    for one in islice(distinct(tried), MAX_VERIFIED):
        found = _verified(task, at(one.point), journal, notes)
        if found:
            return found
    return None


def _verified(
    task: LearningTask, found: tuple[BodyPlan, SwimPlan], journal: Journal, notes: list[str]
) -> Muscles | None:
    """Body and gait with all grades and turns, if they pass the verification."""
    plan, swim = found
    body = build_body(plan)
    try:
        swim = with_amplitudes(body, swim)
        faults = whole_faults(body, swim, task.seed)
    except (UserError, ValueError) as fault:
        faults = [str(fault)]
    if faults:
        notes.append(f"gait: rejected: {faults[0]}")
        return None
    assert task.species.turn
    turn = _learn_turn(task, plan, swim, journal, notes)
    return None if turn is None else Muscles(plan, swim, turn)


def whole_faults(body: Body, swim: SwimPlan, seed: int) -> list[str]:
    """Verify that a gait can be recorded and withstands disturbances; UserError for a lost shape.

    The aims of its fast grade are not checked: the best that was found is what a body can do.
    """
    beats = [steady_beat(body, grade_contraction(swim, grade)).frames for grade in swim.grades]
    speeds = [float(np.linalg.norm(displacement(one))) / (len(one) - 1) for one in beats]
    for name, below, speed in zip(swim.grades[1:], speeds[:-1], speeds[1:], strict=True):
        if speed < LEAST_RATIO * below:
            return [f"{name} is only {speed / below:.2f} times as fast as the grade below"]
    graded = [(swim.at(grade), swim.amplitude(grade)) for grade in swim.grades]
    return disturbed_faults(body, [*graded, (swim, HALF)], seed)


def _learn_turn(
    task: LearningTask, plan: BodyPlan, swim: SwimPlan, journal: Journal, notes: list[str]
) -> TurnPlan | None:
    old = task.species.turn
    assert old
    # Sharp turns are the widest of the steering map; the controller plays parts of them.
    old = msgspec.structs.replace(old, sharp=old.steering[-1].angle)
    body = build_body(plan)

    def optimize(
        loss: Callable[[Any], float], at: Callable[[Any], TurnPlan], start: Floats
    ) -> list[Evaluation]:
        remembered = journal.remembered(lambda point: loss(at(point)))
        return search(remembered, start, "cma", turn_budget(task.budget), task.seed)

    # Recorded turns begin at phase 0.
    found = verified_turn(body, swim, old, True, task.seed, optimize, notes, any_phase=False)
    return found or refit_holds(body, swim, old, task.seed, notes, any_phase=False)
