"""The water's flow: a uniform current whose strength swings (Tu §8.1)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.state import Fishes, Sea

PERIOD_S = 14.0


def flow_at(current_cm_s: tuple[float, float], time_s: float) -> NDArray[np.floating[Any]]:
    """Velocity of the water (3,) in cm/s: v = a·sin(ωt) along a fixed direction."""
    swing = np.sin(2 * np.pi * time_s / PERIOD_S)
    return np.array([current_cm_s[0] * swing, current_cm_s[1] * swing, 0.0])


def carry(fishes: Fishes, sea: Sea, flow: NDArray[np.floating[Any]]) -> None:
    """Set `fishes.drift`: the velocity of the water where each fish is."""
    fishes.drift[:] = flow
