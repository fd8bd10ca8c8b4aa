"""Simulate a fish by ticks and record its nodes (Tu §4.5.2)."""

from typing import NamedTuple

import numpy as np

from subsea.biomechanics.body import MUSCLES, NODES, Body, Floats, Material
from subsea.biomechanics.controllers import muscle_lengths
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, STRAIN_LIMITS, advance
from subsea.kernels import kernel

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
    every: int = STEPS_PER_TICK,
) -> Floats:
    """Advance ``state`` and return its nodes after every tick, (T, 23, 3) in cm.

    ``contraction`` (6 T, 12) holds the muscles' contractions of each step; ``water`` (3,) is the
    velocity of the water in cm/tu and ``force`` (23, 3) a further constant force in g cm/tu².
    ``every`` is the number of steps between two frames. Raises ValueError where the number of steps
    is not a whole number of ticks.
    """
    frames = np.empty((ticks_of(contraction, every), NODES, 3))
    muscles = muscle_lengths(body, contraction)
    advance_frames(state, body.material, muscles, water, force, step, frames)
    return frames


@kernel
def advance_frames(
    state: BodyState,
    material: Material,
    muscles: Floats,
    water: Floats,
    force: Floats,
    step: float,
    frames: Floats,
) -> None:
    """Advance a body by the steps of ``muscles`` (k T, 12), and write its nodes after every k.

    ``frames`` (T, 23, 3) receive the nodes; all else is as of `solver.advance`.
    """
    for n in range(len(frames)):
        every = len(muscles) // len(frames)
        part = muscles[n * every : (n + 1) * every]
        advance(state.x, state.v, material, part, water, force, step, state.watch)
        for node in range(NODES):
            for axis in range(3):
                frames[n, node, axis] = state.x[node, axis]


def ticks_of(contraction: Floats, every: int = STEPS_PER_TICK) -> int:
    """Number of ticks of contractions (6 T, 12); ValueError for another shape."""
    ticks, left_over = divmod(len(contraction), every)
    if left_over or contraction.shape[1:] != (MUSCLES,):
        raise ValueError(f"contraction {contraction.shape} is not ({every} T, {MUSCLES})")
    return ticks


def is_sound(state: BodyState) -> bool:
    """True if the body kept its shape: finite, definite, every unit within its strain limits.

    Finite numbers alone prove nothing: a ring turned inside out is still finite.
    """
    least, greatest, pivot = state.watch
    low, high = STRAIN_LIMITS
    return bool(np.isfinite(state.x).all() and low <= least and greatest <= high and pivot > 0)
