"""Learn a species' body and gaits against those of real fishes, then its turns.

One search finds material, distribution of mass and the fast gait together (body_space.py,
lifelike.py). On the best bodies a search for each other grade finds its gait. The gradual turn
follows from measured headings (turn.py). Of the candidates that pass the verification the one with
the least loss of all grades is taken.
"""

from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from capture.learning.body_space import (
    BODY_SIZE,
    FIRST_TICKS,
    GAIT_SIZE,
    body_at,
    gait_at,
    gait_point,
    species_point,
)
from capture.learning.fitness import disturbed_faults, steady_speed
from capture.learning.journal import Journal
from capture.learning.lifelike import POOR, grade_waves, wave_course
from capture.learning.search import SPREAD, distinct, search
from capture.learning.turn import with_gradual
from capture.recording.fingerprint import fingerprint
from subsea.base.errors import UserError
from subsea.biomechanics.body import Body, Floats, build_body
from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan
from subsea.biomechanics.together import Course, swim_together
from subsea.fish.scaffold import volumes_at
from subsea.fish.species import Species

ROOT = "capture.learning.whole"
LEAST_RATIO = 1.05  # of the speeds of neighbouring grades
MAX_TRIED, MAX_SEARCHED = 40, 10  # most candidates, and most whose other grades are searched ...
ENOUGH_SEARCHED = 3  # ... as long as none passes the verification
GRADE_BUDGET = 250  # evaluations of a search for the gait of a grade
GRADE_SEARCHES, GOOD = 3, 1.0  # most searches, and the loss of a gait for which no more are needed
NEARBY = 0.07  # first steps of a search that begins at a sound gait


class LearningTask(NamedTuple):
    """A species to learn, and the options of the search."""

    name: str
    species: Species
    body: bool  # search the body too
    budget: int  # evaluations of the search for gaits
    seed: int
    journal: Path
    quick: bool = False  # take the first body that passes, without a burst


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
    volumes = volumes_at(task.species.surface, muscles.body.stations)
    size = GAIT_SIZE + BODY_SIZE if task.body else GAIT_SIZE
    plain = without_grades(muscles.swim)

    def at(point: Floats | tuple[float, ...]) -> tuple[BodyPlan, SwimPlan]:
        place = np.asarray(point)
        plan = body_at(muscles.body, place[GAIT_SIZE:], volumes) if task.body else muscles.body
        return plan, gait_at(build_body(plan), plain, "fast", place)

    def course(point: Floats) -> Course[float]:
        plan, swim = at(point)
        return wave_course(build_body(plan), swim, "fast", task.seed)

    own, firm = (
        species_point(muscles.body, muscles.swim, volumes, firm)[:size] for firm in (False, True)
    )

    def side_by_side(points: Sequence[Floats]) -> list[float]:
        return swim_together([course(point) for point in points])

    remembered = journal.remembered(side_by_side)
    (first,) = remembered([own])
    known = first < POOR  # a species that was learned before
    start, spread, budget = (own, NEARBY, task.budget) if known else (firm, SPREAD, task.budget - 1)

    def losses(points: Sequence[Floats]) -> list[float]:
        new = [not (known and np.array_equal(point, own)) for point in points]
        found = iter(remembered([point for point, ask in zip(points, new, strict=True) if ask]))
        return [next(found) if ask else first for ask in new]

    tried = search(losses, start, "cma", budget, task.seed, spread=spread)
    best, least, searched = None, np.inf, 0
    enough = 1 if task.quick else ENOUGH_SEARCHED
    for candidate in islice(distinct(tried), MAX_TRIED):
        plan, swim = at(candidate.point)
        swim, others = _with_grades(build_body(plan), swim, task, journal)
        searched += np.isfinite(others)
        if searched > (enough if best else MAX_SEARCHED):
            break
        if candidate.loss + others >= least:
            continue
        if learned := _verified(task, plan, swim, notes):
            best, least = learned, candidate.loss + others
    return best


def without_grades(swim: SwimPlan) -> SwimPlan:
    """A plan of its fast gait alone, which the other grades begin with."""
    return SwimPlan(
        ticks_per_beat=swim.ticks_per_beat,
        contraction=swim.contraction,
        lag=swim.lag,
        slow=0.8,
        medium=0.9,
        burst=1.0,
        burst_contraction=swim.contraction,
    )


def _with_grades(
    body: Body, swim: SwimPlan, task: LearningTask, journal: Journal
) -> tuple[SwimPlan, float]:
    """Search the gait of each other grade on a given body; return the plan and their losses."""
    try:
        fast, total = steady_speed(body, swim, "fast") / float(np.ptp(body.rest[:, 0])), 0.0
    except UserError:
        return swim, np.inf
    for grade, ticks in FIRST_TICKS.items():
        if grade == "fast" or (grade == "burst" and task.quick):
            continue
        swim, loss = _with_grade(body, swim, grade, ticks, fast, task, journal)
        total += loss if grade != "burst" else 0.0  # a fish may lack it
    return swim, total


def _with_grade(
    body: Body,
    swim: SwimPlan,
    grade: str,
    ticks: int,
    fast: float,
    task: LearningTask,
    journal: Journal,
) -> tuple[SwimPlan, float]:
    """Search the gait of a grade; of several searches the best that withstands disturbances."""
    seed = task.seed

    def losses(points: Sequence[Floats]) -> list[float]:
        gaits = [gait_at(body, swim, grade, point) for point in points]
        return swim_together([wave_course(body, gait, grade, seed, fast) for gait in gaits])

    start = gait_point(body, swim, grade, ticks)
    found = []
    for attempt in range(GRADE_SEARCHES):
        remembered = journal.remembered(losses)
        best = search(remembered, start, "cma", GRADE_BUDGET, seed + attempt)[0]
        plan = gait_at(body, swim, grade, best.point)
        weak = bool(_grade_faults(body, plan, grade, seed))
        found.append((weak, best.loss, attempt, plan))
        if not weak and (task.quick or best.loss < GOOD):
            break
    _, least, _, plan = min(found)
    return plan, least


def _grade_faults(body: Body, swim: SwimPlan, grade: str, seed: int) -> list[str]:
    """Why a grade cannot be recorded; empty for a steady one that withstands disturbances."""
    try:
        steady_speed(body, swim, grade)
    except UserError as fault:
        return [str(fault)]
    return disturbed_faults(body, [(swim.at(grade), swim.amplitude(grade))], seed)


def _verified(
    task: LearningTask, plan: BodyPlan, swim: SwimPlan, notes: list[str]
) -> Muscles | None:
    """Body and gaits with turns, if they pass the verification."""
    body = build_body(plan)
    try:
        swim = _with_fit_burst(body, swim)
        faults = whole_faults(body, swim, task.seed)
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
        fast, burst = (steady_speed(body, swim, grade) for grade in ("fast", "burst"))
    except UserError:
        burst = fast = 1.0
    if burst >= LEAST_RATIO * fast:
        return swim
    return msgspec.structs.replace(
        swim, burst=None, burst_ticks=None, burst_contraction=None, burst_lag=None
    )


def whole_faults(body: Body, swim: SwimPlan, seed: int) -> list[str]:
    """Verify that a gait can be recorded and withstands disturbances; UserError for a lost shape.

    The aims of its fast grade are not checked: the best that was found is what a body can do.
    """
    for grade, wave in grade_waves(body, swim).items():
        if np.isinf(wave.wavelength):
            return [f"no wave runs to its tail at grade {grade}"]
    speeds = [steady_speed(body, swim, grade) for grade in swim.grades]
    for name, below, speed in zip(swim.grades[1:], speeds[:-1], speeds[1:], strict=True):
        if speed < LEAST_RATIO * below:
            return [f"{name} is only {speed / below:.2f} times as fast as the grade below"]
    for grade in swim.grades:
        if faults := _grade_faults(body, swim, grade, seed):
            return [f"{grade}: {faults[0]}"]
    return []
