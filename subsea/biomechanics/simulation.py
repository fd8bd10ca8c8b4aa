"""Simulate a fish by ticks and record its nodes (Tu §4.5.2)."""

from typing import NamedTuple

import numpy as np

from subsea.biomechanics.body import MUSCLES, NODES, Body, Floats
from subsea.biomechanics.controllers import muscle_lengths
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, STRAIN_LIMITS, advance

STILL = np.zeros(3)
NO_FORCE = np.zeros((NODES, 3))


class BodyState(NamedTuple):
    """A fish in motion; :func:`simulate` changes the arrays in place."""

    x: Floats  # (23, 3) cm
    v: Floats  # (23, 3) cm/tu
    watch: Floats  # (3,) least and greatest length ratio of any unit, smallest pivot so far


def at_rest(body: Body) -> BodyState:
    """The body at rest, its frame on the axes of the world."""
    return BodyState(body.rest.copy(), np.zeros((NODES, 3)), np.array([np.inf, 0.0, np.inf]))


def copy_state(state: BodyState) -> BodyState:
    """An independent copy."""
    return BodyState(*(array.copy() for array in state))


def simulate(
    body: Body,
    state: BodyState,
    contraction: Floats,
    water: Floats = STILL,
    force: Floats = NO_FORCE,
    step: float = STEP,
) -> Floats:
    """Advance ``state`` and return its nodes after every tick, (T, 23, 3) in cm.

    ``contraction`` (6 T, 12) holds the muscles' contractions of each step; ``water`` (3,) is the
    velocity of the water in cm/tu and ``force`` (23, 3) a further constant force in g cm/tu².
    Raises ValueError where the number of steps is not a whole number of ticks.
    """
    ticks, left_over = divmod(len(contraction), STEPS_PER_TICK)
    if left_over or contraction.shape[1:] != (MUSCLES,):
        raise ValueError(f"contraction {contraction.shape} is not (6 T, {MUSCLES})")
    muscles = muscle_lengths(body, contraction)
    material = body.material
    frames = np.empty((ticks, NODES, 3))
    for tick in range(ticks):
        advance(
            state.x,
            state.v,
            material,
            muscles[tick * STEPS_PER_TICK : (tick + 1) * STEPS_PER_TICK],
            water,
            force,
            step,
            state.watch,
        )
        frames[tick] = state.x
    return frames


def is_sound(state: BodyState) -> bool:
    """True if the body kept its shape: finite, definite, every unit within its strain limits.

    Finite numbers alone prove nothing: a ring turned inside out is still finite.
    """
    least, greatest, pivot = state.watch
    low, high = STRAIN_LIMITS
    return bool(np.isfinite(state.x).all() and low <= least and greatest <= high and pivot > 0)
