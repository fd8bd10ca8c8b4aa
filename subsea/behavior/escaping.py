"""Escaping from a predator (Tu §7.9.2)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.vector import minus, vector
from subsea.state import FEAR, NOBODY, PREY, SUBMARINE, Clock, Fishes, Minds, Nature, Sea

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]


@njit(cache=True, error_model="numpy")
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Fear above f0, of prey that don't school or see one predator as fearful as f1 (Tu §7.5)."""
    for i in who:
        fear = minds.mental[i, FEAR]
        panics = minds.menace[i] >= nature.panicked or not minds.schools[i]
        out[i] = fear if minds.kind[i] == PREY and fear > nature.alarmed and panics else 0.0


@njit(cache=True, error_model="numpy")
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Swim away from the most dangerous predator as fast as possible."""
    for i in who:
        j = minds.predator[i]
        if j == NOBODY:
            continue
        danger = vector(sea.submarine) if j == SUBMARINE else vector(fishes.position[j])
        away = minus(vector(fishes.position[i]), danger)
        for axis in range(3):
            minds.urge[i, axis] = away[axis]
        fishes.goal_speed[i] = 1.0
