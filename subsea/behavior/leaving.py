"""Leave places that are too bright, dark, cold or warm (Tu §7.3, §7.5)."""

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.wandering import cruise, heading
from subsea.kernels import kernel
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

DUSK = 0.4  # light below which it is dark
MILD_C = 23.0  # temperature below which it is cold
CLIMB = 0.8  # how steeply a fish leaves upward or downward
BRISK = 0.7  # share of the fastest speed


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Desire slightly above wandering where light or temperature is disliked; not predators."""
    for i in who:
        upset = _wanted_rise(minds, i) != 0.0 and minds.kind[i] != PREDATOR
        out[i] = 0.015 if upset else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Wander upward to light and warmth, or downward to darkness and cold."""
    for i in who:
        toward = heading(fishes, minds, i, sea, clock)
        set_urge(minds, i, (toward[0], toward[1], CLIMB * _wanted_rise(minds, i)))
        fishes.goal_speed[i] = max(cruise(fishes, minds, i), BRISK)


@kernel
def _wanted_rise(minds: Minds, i: int) -> float:
    """1 if the habits of fish i lead upward, -1 if downward, 0 if neither or both."""
    rise, light, temperature = 0.0, minds.light[i], minds.temperature[i]
    if _likes(minds, i, BRIGHTNESS) != _likes(minds, i, DARKNESS):
        if _likes(minds, i, BRIGHTNESS) and light < DUSK:
            rise += 1.0
        if _likes(minds, i, DARKNESS) and light >= DUSK:
            rise -= 1.0
    if _likes(minds, i, WARMTH) != _likes(minds, i, COLD):
        if _likes(minds, i, WARMTH) and temperature < MILD_C:
            rise += 1.0
        if _likes(minds, i, COLD) and temperature >= MILD_C:
            rise -= 1.0
    return min(max(rise, -1.0), 1.0)


@kernel
def _likes(minds: Minds, i: int, habit: int) -> bool:
    """True if fish i has a habit, its own or one set by a direction."""
    fancy = int(minds.fancy[i])
    return bool(minds.likes[i, habit]) if fancy < 0 else (fancy >> habit) & 1 == 1
