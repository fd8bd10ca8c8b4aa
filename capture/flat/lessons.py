"""Learn to swim and to turn by simulated annealing, and swim to a goal (KS I.D, IV.A)."""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from capture.flat.controllers import (
    FRAME,
    LARGEST,
    RISE_TU,
    STEP_TU,
    Sinusoids,
    controller_at,
    distance,
    lengths,
    passage,
    run,
    steps_of,
    swim_by,
    turned,
)
from capture.flat.physics import heading, middle
from capture.flat.scaffold import FlatBody
from subsea.base.errors import UserError
from subsea.base.progress import progress
from subsea.biomechanics.body import Floats

HOT_L, HOT_DEG = 0.3, 5.0  # first temperatures: a step that is worse by this is often taken
NEAR_L = 0.5  # body lengths from its goal at which a fish has arrived
ASTRAY_DEG, RIGHT_DEG = 30.0, 10.0  # off course by more it begins to turn, by less it ends


class Annealing(NamedTuple):
    """The evaluations of a search, in order."""

    points: Floats  # (tries, d)
    scores: Floats  # (tries,)
    held: Floats  # (tries,) the score that it stood at

    @property
    def best(self) -> Floats:
        """The best score so far (tries,)."""
        return np.maximum.accumulate(self.scores)

    @property
    def winner(self) -> Floats:
        """The best point (d,)."""
        return np.asarray(self.points[self.scores.argmax()])


def anneal(
    score: Callable[[Floats], float], dimensions: int, tries: int, seed: int, hot: float
) -> Annealing:
    """Maximise a score in the unit box, from a random point (Metropolis, geometric cooling).

    A step worse by d is accepted with probability exp(-d/T); T falls from ``hot`` to a hundredth
    of it, and the step size falls with its square root. Walls reflect.
    """
    rng = np.random.default_rng(seed)
    here, standing = rng.random(dimensions), -np.inf
    points: list[Floats] = []
    scores: list[float] = []
    held: list[float] = []
    for temperature in hot * np.geomspace(1.0, 0.01, tries):
        step = 0.25 * np.sqrt(temperature / hot) * rng.normal(size=dimensions)
        point = here if not points else 1.0 - np.abs(1.0 - np.abs(here + step) % 2.0)
        reached = score(point)
        if reached >= standing or rng.random() < np.exp((reached - standing) / temperature):
            here, standing = point, reached
        points.append(point)
        scores.append(reached)
        held.append(standing)
    return Annealing(np.array(points), np.array(scores), np.array(held))


class Effort(NamedTuple):
    """Sizes of the experiments."""

    seeds: int = 8
    tries: int = 600
    turn_seeds: int = 4
    turn_tries: int = 400
    folds: int = 150
    bound_seeds: int = 3
    moments: int = 40


QUICK = Effort(2, 60, 1, 40, 12, 1, 4)


class FlatLearner:
    """A flat fish, and the controllers that it learns when they are first asked for."""

    def __init__(self, body: FlatBody, effort: Effort, seed: int = 1) -> None:
        self.body, self.effort, self._seed = body, effort, seed

    def _search(
        self, score: Callable[[Floats], float], dimensions: int, tries: int, seeds: int, hot: float
    ) -> list[Annealing]:
        """Anneal with several seeds."""
        with progress(seeds * tries, "try") as count:

            def counted(point: Floats) -> float:
                count()
                return score(point)

            numbers = range(self._seed, self._seed + seeds)
            return [anneal(counted, dimensions, tries, seed, hot) for seed in numbers]

    def learn_swims(
        self, tries: int, seeds: int, largest: float = LARGEST, frequencies: int = 1
    ) -> list[Annealing]:
        """Learn to swim within a bound of the amplitudes."""
        return self._search(
            lambda point: distance(self.body, controller_at(self.body, point, largest)),
            2 * len(self.body.mirror) + frequencies, tries, seeds, HOT_L,
        )  # fmt: skip

    @cached_property
    def swims(self) -> list[Annealing]:
        """Swims learned with one frequency for all muscles."""
        return self.learn_swims(self.effort.tries, self.effort.seeds)

    @cached_property
    def many(self) -> list[Annealing]:
        """Swims learned with a frequency for each muscle."""
        muscles = len(self.body.mirror)
        return self.learn_swims(self.effort.tries, self.effort.seeds, frequencies=muscles)

    @cached_property
    def turns(self) -> list[Annealing]:
        """Turns to the left learned while it swims."""
        return self._search(
            lambda point: turned(self.body, self.swum, controller_at(self.body, point)),
            2 * len(self.body.mirror) + 1,
            self.effort.turn_tries, self.effort.turn_seeds, HOT_DEG,
        )  # fmt: skip

    @cached_property
    def swum(self) -> Floats:
        """The state (2, n, 2) of the best swimmer at the end of its try."""
        return swim_by(self.body, self.swimmer)[-1]

    @property
    def swimmer(self) -> Sinusoids:
        """The best swimming controller; a UserError if every try folds the fish."""
        best = best_first(self.swims)[0]
        if best.scores.max() <= -1.0:
            raise UserError(
                f"every swim of {self.effort.tries} tries folds the scaffold; expected edges that "
                "keep its shape, such as crosses"
            )
        return controller_at(self.body, best.winner)

    @property
    def turner(self) -> Sinusoids:
        """The best turning controller."""
        return controller_at(self.body, best_first(self.turns)[0].winner)

    def swim_to(self, goal: Floats, way: str = "lengths", longest_tu: float = 600.0) -> Floats:
        """Swim from rest to ``goal`` (2,), cm, by three controllers: states (frames, 2, n, 2)."""
        body, swimmer, left = self.body, self.swimmer, self.turner
        controllers = {0: swimmer, 1: left, -1: left.mirrored(body)}
        chosen, time = 0, RISE_TU
        frames = [run(body, lengths(body, swimmer, steps_of(RISE_TU)))]
        while time < longest_tu:
            state = frames[-1][-1]
            to = goal - middle(body, state[0])
            if not np.isfinite(state).all() or np.hypot(*to) < NEAR_L * body.long:
                break
            off = np.arctan2(to[1], to[0]) - heading(body, state[:1])[0]
            off = np.degrees((off + np.pi) % (2.0 * np.pi) - np.pi)
            wanted = int(np.sign(off)) if abs(off) > (RIGHT_DEG if chosen else ASTRAY_DEG) else 0
            if wanted == chosen:
                muscles = lengths(body, controllers[chosen], FRAME * 3, time)
            else:
                muscles = passage(body, controllers[chosen], controllers[wanted], time, way)
                chosen = wanted
            frames.append(run(body, muscles, state)[1:])
            time += STEP_TU * len(muscles)
        return np.concatenate(frames)


def best_first(runs: list[Annealing]) -> list[Annealing]:
    """Sort runs by their best scores."""
    return sorted(runs, key=lambda run: -run.scores.max())
