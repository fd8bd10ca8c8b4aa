"""Episodes of many bodies: their starts, goals and steps, and rewards.

SwimEnv is a school of one.
"""

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from gymnasium import spaces

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.errors import UserError
from subsea.base.system import cores
from subsea.biomechanics.body import NODES
from subsea.biomechanics.body_plan import Muscles
from subsea.biomechanics.solver import TICK_S
from subsea.fish.species import Species, load_species, muscular_names
from subsea.lab.environments.swim_bodies import (
    ACTIONS,
    BOUND,
    OBSERVED,
    make_bodies,
    observe,
    swim,
)
from subsea.lab.environments.swim_tasks import (
    ARRIVED,
    PLACE_DISTANCES,
    Reward,
    SwimStep,
    draw_goal,
    task_named,
)

DISTURBANCE = 0.1  # rms random velocity of each node at the start, cm/tu
LEAST_PART = 16  # bodies, about 0.3 ms of work: fewer are not worth a thread
PARTS_PER_THREAD = 4  # a thread that is held up then delays the step less

ACTION_SPACE = spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32)
OBSERVATION_SPACE = spaces.Box(-BOUND, BOUND, (OBSERVED,), np.float32)


class Exercise(NamedTuple):
    """The task of a school."""

    species: str = "fusilier"
    task: str = "speed"
    reward: Reward | None = None  # replaces that of the task
    frame_skip: int = 1  # ticks of 0.033 s in a step


class SwimSchool:
    """Bodies of one species, each in an episode of its own."""

    def __init__(self, number: int, exercise: Exercise, threads: int | None = 1) -> None:
        """Make ``number`` bodies; ``threads`` None: one for each core.

        UserError for an unknown species or task, or for a count below 1.
        """
        for name, count in (
            ("num_envs", number), ("frame_skip", exercise.frame_skip), ("threads", threads)
        ):  # fmt: skip
            if count is not None and count < 1:
                raise UserError(f"{name} = {count}; expected 1 or more")
        self.species, muscles = _muscular(exercise.species)
        task = task_named(exercise.task)
        self._goal, self._reward = task.goal, exercise.reward or task.reward
        self._ticks = exercise.frame_skip
        length = muscles.body.length
        reach = PLACE_DISTANCES[1] * length if task.goal == "place" else 0.0
        self.bodies = make_bodies(muscles, number, reach)
        self._step = SwimStep(
            self.bodies.toward,
            self.bodies.work,
            self._ticks * TICK_S,
            self.bodies.total_toward,
            self.bodies.total_work,
            self.bodies.total_seconds,
            self.bodies,
        )
        self._threads = threads or cores()
        self._pool = ThreadPoolExecutor(self._threads, "swim") if self._threads > 1 else None

    def close(self) -> None:
        """End the threads."""
        if self._pool:
            self._pool.shutdown()
            self._pool = None

    def begin(self, who: Ints, randoms: list[np.random.Generator]) -> None:
        """Begin episodes of the bodies ``who``; ``randoms[i]`` is the generator of body i."""
        bodies = self.bodies
        bodies.x[who], bodies.command[who] = bodies.rest, 0.0
        bodies.sound[who] = True
        bodies.toward[who], bodies.work[who], bodies.total_seconds[who] = 0.0, 0.0, 0.0
        bodies.total_toward[who], bodies.total_work[who] = 0.0, 0.0
        for i in who.tolist():
            bodies.v[i] = randoms[i].normal(0.0, DISTURBANCE, (NODES, 3))
            self._draw_goal(i, randoms[i])
        observe(who, bodies)

    def step(self, who: Ints, actions: Array, randoms: list[np.random.Generator]) -> Array:
        """Advance the bodies ``who`` under ``actions`` (n, 16); return the rewards of all (n,)."""
        self._swim(who, actions)
        rewards = np.array(self._reward(self._step), np.float64)
        if self.bodies.reach > 0.0:
            arrived = who[self._distances()[who] < ARRIVED * self.bodies.body_length]
            for i in arrived.tolist():
                self._draw_goal(i, randoms[i])
            observe(arrived, self.bodies)
        return rewards

    def burst(self) -> Bools:
        """True for bodies (n,) that lost their shape in their last step."""
        return ~self.bodies.sound

    def _swim(self, who: Ints, actions: Array) -> None:
        """Advance bodies, on the threads if there are enough of them.

        A body computes the same in any part, so the number of threads changes nothing.
        """
        parts = min(PARTS_PER_THREAD * self._threads, len(who) // LEAST_PART)
        if self._pool is None or parts < 2:
            swim(who, self.bodies, actions, self._ticks)
            return
        cut = np.array_split(who, parts)
        list(self._pool.map(lambda part: swim(part, self.bodies, actions, self._ticks), cut))

    def _distances(self) -> Array:
        """Distances (n,) of the bodies from their places, cm."""
        origins = 0.5 * (self.bodies.x[:, 5] + self.bodies.x[:, 7])
        return np.asarray(np.linalg.norm(self.bodies.goal - origins, axis=1))

    def _draw_goal(self, i: int, random: np.random.Generator) -> None:
        x = self.bodies.x[i]
        length = self.bodies.body_length
        self.bodies.goal[i] = draw_goal(self._goal, 0.5 * (x[5] + x[7]), length, random)


def checked_actions(actions: object, shape: tuple[int, ...]) -> Array:
    """Actions as a float32 array; ValueError for another shape or values that are not finite."""
    try:
        array = np.ascontiguousarray(actions, np.float32)
    except (TypeError, ValueError):
        raise ValueError(f"the action is not an array of numbers; expected shape {shape}") from None
    if array.shape != shape:
        raise ValueError(f"the action has shape {array.shape}; expected {shape}")
    if not np.isfinite(array).all():
        raise ValueError("the action has a value that is not finite; expected -1 to 1")
    return array


def _muscular(name: str) -> tuple[Species, Muscles]:
    species = load_species(name)
    if species.muscles is None:
        raise UserError(
            f"species {name!r} has no muscles; expected one of {', '.join(muscular_names())}"
        )
    return species, species.muscles
