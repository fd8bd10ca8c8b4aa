"""Leaving a place that is too bright, dark, cold or warm (Tu §7.3, §7.5)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.behavior.wandering import cruise, heading
from subsea.state import (
    BRIGHTNESS,
    COLD,
    DARKNESS,
    PREDATOR,
    WARMTH,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

DUSK = 0.4  # less light than that is dark
MILD_C = 23.0  # water below that is cold
CLIMB = 0.8  # how steeply a fish leaves upward or downward
BRISK = 0.7  # share of the fastest speed


@njit(cache=True, error_model="numpy")
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """More than wandering, where the fish dislikes light or temperature; predators never."""
    for i in who:
        upset = (
            _wanted_rise(minds.likes[i], minds.light[i], minds.temperature[i]) != 0.0
            and minds.kind[i] != PREDATOR
        )
        out[i] = 0.015 if upset else 0.0


@njit(cache=True, error_model="numpy")
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Wander, but upward to light and warmth, downward to darkness and cold."""
    for i in who:
        toward = heading(fishes, minds, i, sea, clock)
        minds.urge[i, 0] = toward[0]
        minds.urge[i, 1] = toward[1]
        minds.urge[i, 2] = CLIMB * _wanted_rise(
            minds.likes[i], minds.light[i], minds.temperature[i]
        )
        fishes.goal_speed[i] = max(cruise(fishes, minds, i), BRISK)


@njit(cache=True, error_model="numpy")
def _wanted_rise(likes: NDArray[np.bool_], light: float, temperature: float) -> float:
    """1 if the fish wants upward to be content, -1 if downward, 0 if it is or if they cancel."""
    rise = 0.0
    if likes[BRIGHTNESS] != likes[DARKNESS]:
        if likes[BRIGHTNESS] and light < DUSK:
            rise += 1.0
        if likes[DARKNESS] and light >= DUSK:
            rise -= 1.0
    if likes[WARMTH] != likes[COLD]:
        if likes[WARMTH] and temperature < MILD_C:
            rise += 1.0
        if likes[COLD] and temperature >= MILD_C:
            rise -= 1.0
    return min(max(rise, -1.0), 1.0)
