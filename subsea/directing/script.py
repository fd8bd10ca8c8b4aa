"""Directions of a scenario resolved to indices of fishes, in order of dependence."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.mental_state import urge_to_eat
from subsea.scenario.directions import Direction, FishSelector
from subsea.scenario.schema import Scenario
from subsea.scenario.shoals import Shoals, numbers_of
from subsea.state import Clock, Nature, State

Cast = tuple[int, int]  # two fishes, NOBODY or SUBMARINE


class Cue(NamedTuple):
    """A direction resolved to indices of fishes."""

    direction: Direction
    influences: tuple[str, ...]  # names of its influences
    who: Ints  # fishes that it moves
    of: Ints  # fishes whose event it waits for
    prey: Ints  # prey of a hunt
    shown: Ints  # fishes that its camera follows
    after: int  # index of the direction that it follows, -1 for none


class Script(NamedTuple):
    """All directions of a world; constant."""

    cues: tuple[Cue, ...]
    order: tuple[int, ...]  # indices, each after the one that it follows
    species: tuple[str, ...]  # names by index


class DirectingContext(NamedTuple):
    """World and time in which directions act."""

    script: Script
    state: State
    nature: Nature
    current_cm_s: tuple[float, float]  # without directions
    clock: Clock


def make_script(scenario: Scenario, numbers: list[int]) -> Script:
    """Resolve the directions of a scenario whose shoals have these numbers of fishes."""
    shoals = Shoals([shoal.species for shoal in scenario.fish], numbers)
    everybody = np.arange(sum(numbers))

    def those(whose: FishSelector | None) -> Ints:
        return everybody if whose is None else np.array(numbers_of(whose, shoals), np.int64)

    def shown(one: Direction) -> Ints:
        follow = None if one.camera is None else one.camera.follow
        return those(follow) if isinstance(follow, FishSelector) else np.zeros(0, np.int64)

    names = {one.name: k for k, one in enumerate(scenario.direction) if one.name}
    cues = tuple(
        Cue(
            one,
            one.influences,
            those(one.who),
            those(one.of),
            those(one.hunts if isinstance(one.hunts, FishSelector) else None),
            shown(one),
            names.get(one.after or "", -1),
        )
        for one in scenario.direction
    )

    def depth(k: int) -> int:
        return 0 if cues[k].after < 0 else 1 + depth(cues[k].after)

    order = tuple(sorted(range(len(cues)), key=depth))
    return Script(cues, order, tuple(scenario.species))


def now_s(context: DirectingContext) -> float:
    """World time, s."""
    return context.clock.tick * context.clock.dt


def hunger_of(context: DirectingContext, those: Ints) -> Array:
    """Urge of fishes to eat, without the stimulus of food in sight."""
    urge: Array = urge_to_eat(context.state.minds, those, now_s(context))
    return urge
