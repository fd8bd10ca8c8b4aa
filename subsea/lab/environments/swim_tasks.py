"""Tasks of the swimming environments: a goal, and a reward that is a small function."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.lab.environments.swim_bodies import SwimBodies

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
    """Body lengths toward the goal. The return is the distance covered."""
    return swim.toward


def distance_per_work(swim: SwimStep) -> Array:
    """Change of the distance per work, L kg/J. The return is that of the whole episode."""
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


def task_named(name: str) -> SwimTask:
    """The task of this name; UserError if there is none."""
    if name not in TASKS:
        raise UserError(f"unknown task {name!r}; expected one of {', '.join(TASKS)}")
    return TASKS[name]


def draw_goal(
    goal: str, origin: Array, body_length: float, random: np.random.Generator
) -> tuple[float, float, float]:
    """A new goal of a body at ``origin`` (3,): a direction of length 1, or a place in cm."""
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
