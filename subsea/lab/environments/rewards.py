"""Rewards of the environments: functions of an `Outcome` that return a number for each fish.

Any function of this form can replace them: it may read all of `outcome.world`.
"""

from collections.abc import Callable

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.periodic import shortest
from subsea.lab.environments.living_sea import Outcome
from subsea.lab.measures import headings
from subsea.state import HUNGER, NOBODY, PREDATOR

Reward = Callable[[Outcome], Array]

HUNGER_PER_S = 0.02  # cost of full hunger, meals per second
CAUGHT = -1.0
SURVIVAL_PER_S = 0.1
COHESION_BL = 4.0  # mean distance of companions at which cohesion has fallen to 1/e
COLLISION_BL = 0.3  # distance of two fishes, in mean body lengths, below which they collide


def forage_reward(outcome: Outcome) -> Array:
    """Reward meals, less a little for hunger and 1 for being eaten."""
    hunger = outcome.world.state.minds.mental[outcome.fish, HUNGER]
    reward = outcome.meals - HUNGER_PER_S * outcome.seconds * hunger
    return np.where(outcome.alive, reward, CAUGHT)


def escape_reward(outcome: Outcome) -> Array:
    """Reward each second alive with 0.1, and being caught with -1."""
    return np.where(outcome.alive, SURVIVAL_PER_S * outcome.seconds, CAUGHT)


def hunt_reward(outcome: Outcome) -> Array:
    """Reward catches of predators; all others by `escape_reward`."""
    hunts = outcome.world.state.minds.kind[outcome.fish] == PREDATOR
    return np.where(hunts, outcome.meals, escape_reward(outcome))


def school_reward(outcome: Outcome) -> Array:
    """Reward polarisation and cohesion with perceived companions, less collisions.

    The mean cosine between its heading and theirs, in [-1, 1]; exp(-d / 4 BL) for their mean
    distance d; -1 for one nearer than 0.3 BL. A fish without company gets 0, one that died -1.
    """
    fishes, who = outcome.world.state.fishes, outcome.fish
    near = outcome.world.state.minds.neighbour[who]
    known = near != NOBODY
    other = np.maximum(near, 0)
    number = np.maximum(known.sum(axis=1), 1)
    ahead = headings(fishes.orientation)
    cosine = np.einsum("ki,kmi->km", ahead[who], ahead[other])
    polarisation = (cosine * known).sum(axis=1) / number
    ways = shortest(fishes.position[other] - fishes.position[who, None], fishes.period)
    gap = np.linalg.norm(ways, axis=2)
    mean_length = (fishes.length[other] + fishes.length[who, None]) / 2
    distance = (gap * known).sum(axis=1) / number / fishes.length[who]
    cohesion = np.where(known.any(axis=1), np.exp(-distance / COHESION_BL), 0.0)
    collides = (known & (gap < COLLISION_BL * mean_length)).any(axis=1)
    return np.where(outcome.alive, polarisation + cohesion - collides, CAUGHT)
