"""Episodes of many swimming bodies: their starts, tasks and steps. SwimEnv is a school of one.

A task is a goal, and a reward that is a small function.
"""

from collections.abc import Callable
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
from subsea.kernels.lanes import LANES
from subsea.lab.environments.swim_bodies import (
    ACTIONS,
    BOUND,
    OBSERVED,
    SwimBodies,
    make_bodies,
    observe,
    swim,
)

RESTING_POWER = 0.1  # W/kg: what a resting fish needs, which makes standing still uneconomic
PLACE_DISTANCES = 3.0, 6.0  # body lengths of a new place from the body
STEEPEST_PLACE = np.radians(30.0)  # above or below the body
ARRIVED = 0.5  # body lengths from a place
TINY = 1e-9


class SwimStep(NamedTuple):
    """The input of a reward: n bodies after a step. L is the body length.

    SwimEnv has n = 1. The arrays change with the next step.
    """

    toward: Array  # (n,) L: distance toward the goal in this step
    work: Array  # (n,) J/kg: work of muscles and fins in this step
    seconds: float  # duration of this step
    total_toward: Array  # (n,) L: in this episode so far
    total_work: Array  # (n,) J/kg
    total_seconds: Array  # (n,)
    bodies: SwimBodies  # nodes, velocities, commands, goals: cm, g and tu


Reward = Callable[[SwimStep], Array]
"""From a step to the rewards (n,)."""


class SwimTask(NamedTuple):
    """A goal and the reward for pursuing it."""

    goal: str  # "ahead", "heading" or "place"
    reward: Reward


def toward_goal(swim: SwimStep) -> Array:
    """Reward body lengths toward the goal. The return is the distance covered."""
    return swim.toward


def distance_per_work(swim: SwimStep) -> Array:
    """Reward distance per work, L kg/J: its change in a step. The return is that of the episode."""
    now = _per_work(swim.total_toward, swim.total_work, swim.total_seconds)
    before = _per_work(
        swim.total_toward - swim.toward,
        swim.total_work - swim.work,
        swim.total_seconds - swim.seconds,
    )
    return np.asarray(now - before)


def _per_work(distance: Array, work: Array, seconds: Array) -> Array:
    spent = np.maximum(work, 0.0) + RESTING_POWER * np.maximum(seconds, 0.0)
    return np.asarray(distance / np.maximum(spent, TINY))


TASKS = {
    "speed": SwimTask("ahead", toward_goal),
    "economy": SwimTask("ahead", distance_per_work),
    "heading": SwimTask("heading", toward_goal),
    "place": SwimTask("place", toward_goal),
}
"""The tasks by name."""


def draw_goal(
    goal: str, origin: Array, body_length: float, random: np.random.Generator
) -> tuple[float, float, float]:
    """Draw a new goal of a body at ``origin`` (3,): a direction of length 1, or a place in cm."""
    if goal == "ahead":
        return 1.0, 0.0, 0.0
    turn = random.uniform(-np.pi, np.pi)
    if goal == "heading":
        return float(np.cos(turn)), 0.0, float(np.sin(turn))
    climb = random.uniform(-STEEPEST_PLACE, STEEPEST_PLACE)
    far = body_length * random.uniform(*PLACE_DISTANCES)
    level = far * np.cos(climb)
    return (
        float(origin[0] + level * np.cos(turn)),
        float(origin[1] + far * np.sin(climb)),
        float(origin[2] + level * np.sin(turn)),
    )


DISTURBANCE = 0.1  # rms random velocity of each node at the start, cm/tu
LEAST_PART = 32  # bodies, about 0.15 ms of work: fewer are not worth a thread
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
        if exercise.task not in TASKS:
            raise UserError(f"unknown task {exercise.task!r}; expected one of {', '.join(TASKS)}")
        task = TASKS[exercise.task]
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
        """Flag bodies (n,) that lost their shape in their last step."""
        return ~self.bodies.sound

    def _swim(self, who: Ints, actions: Array) -> None:
        """Advance bodies, on the threads if there are enough of them.

        A body computes the same in any part, so the number of threads changes nothing.
        """
        parts = min(PARTS_PER_THREAD * self._threads, len(who) // LEAST_PART)
        if self._pool is None or parts < 2:
            swim(who, self.bodies, actions, self._ticks)
            return
        cut = whole_lanes(who, parts)
        list(self._pool.map(lambda part: swim(part, self.bodies, actions, self._ticks), cut))

    def _distances(self) -> Array:
        """Measure distances (n,) of the bodies from their places, cm."""
        origins = 0.5 * (self.bodies.x[:, 5] + self.bodies.x[:, 7])
        return np.asarray(np.linalg.norm(self.bodies.goal - origins, axis=1))

    def _draw_goal(self, i: int, random: np.random.Generator) -> None:
        x = self.bodies.x[i]
        length = self.bodies.body_length
        self.bodies.goal[i] = draw_goal(self._goal, 0.5 * (x[5] + x[7]), length, random)


def whole_lanes(who: Ints, parts: int) -> list[Ints]:
    """Cut ``who`` into about equal parts. All but the last part fill their lanes."""
    groups = -(-len(who) // LANES)
    return np.split(who, LANES * (np.arange(1, parts) * groups // parts))


def checked_actions(actions: object, shape: tuple[int, ...]) -> Array:
    """Check actions; returns float32. ValueError for another shape or infinite values."""
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
