"""Mating (Tu §7.9.3)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.behavior.chasing import chase
from subsea.kinematics.vector import vector
from subsea.state import LIBIDO, PACIFIST, Clock, Fishes, Minds, Nature, Sea

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]


@njit(cache=True, error_model="numpy")
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Libido, if there is more than `keen` of it and somebody to court; only of pacifists."""
    for i in who:
        libido = minds.mental[i, LIBIDO]
        able = minds.kind[i] == PACIFIST and minds.mate[i] >= 0
        out[i] = libido if able and libido > nature.keen else 0.0


@njit(cache=True, error_model="numpy")
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Approach the mate that has the fish's attention."""
    for i in who:
        j = minds.target[i]
        if j >= 0:
            chase(fishes, minds, i, vector(fishes.position[j]), vector(fishes.velocity[j]))
