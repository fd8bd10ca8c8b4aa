"""Directions in the numbers of a world: of which fishes, and in which order."""

from typing import NamedTuple

import numpy as np

from subsea.behavior.temperament import urge_to_eat
from subsea.core.arrays import Array, Ints
from subsea.scenario.directions import Direction, Shoals, Whose, numbers_of
from subsea.scenario.schema import Scenario
from subsea.state import Clock, Nature, State


class Act(NamedTuple):
    """A direction in the numbers of a world."""

    direction: Direction
    influences: tuple[str, ...]  # its own
    who: Ints  # whom it moves
    of: Ints  # whose event it waits for
    prey: Ints  # whom they hunt
    shown: Ints  # whom its camera follows
    after: int  # which direction it follows, -1 for none


class Script(NamedTuple):
    """All directions of a world. Constant."""

    acts: tuple[Act, ...]
    order: tuple[int, ...]  # each behind the one that it follows
    fastest_cm_s: Array  # (n,) float32, of each fish
    species: tuple[str, ...]  # as they are numbered


class Scene(NamedTuple):
    """What a direction acts on."""

    script: Script
    state: State
    nature: Nature
    current_cm_s: tuple[float, float]  # as it is without directions
    clock: Clock


def make_script(scenario: Scenario, numbers: list[int], fastest_cm_s: Array) -> Script:
    """The directions of a scenario of whose shoals so many fishes each live in its world."""
    shoals = Shoals([shoal.species for shoal in scenario.fish], numbers, [])
    everybody = np.arange(sum(numbers))

    def those(whose: Whose | None) -> Ints:
        return everybody if whose is None else np.array([*numbers_of(whose, shoals)], np.int64)

    def shown(one: Direction) -> Ints:
        follow = None if one.camera is None else one.camera.follow
        return those(follow) if isinstance(follow, Whose) else np.zeros(0, np.int64)

    names = {one.name: k for k, one in enumerate(scenario.direction) if one.name}
    acts = tuple(
        Act(
            one,
            one.influences,
            those(one.who),
            those(one.of),
            those(one.hunts if isinstance(one.hunts, Whose) else None),
            shown(one),
            names.get(one.after or "", -1),
        )
        for one in scenario.direction
    )

    def depth(k: int) -> int:
        return 0 if acts[k].after < 0 else 1 + depth(acts[k].after)

    order = tuple(sorted(range(len(acts)), key=depth))
    return Script(acts, order, fastest_cm_s, tuple(scenario.species))


def now_s(scene: Scene) -> float:
    """The time of the world, s."""
    return scene.clock.tick * scene.clock.dt


def hunger_of(scene: Scene, those: Ints) -> Array:
    """The urge of fishes to eat, without what food in sight adds."""
    urge: Array = urge_to_eat(scene.state.minds, those, now_s(scene))
    return urge
