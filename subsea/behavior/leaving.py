"""Leave places that are too bright, dark, cold or warm (Tu §7.3, §7.5)."""

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.schooling import way_back
from subsea.behavior.wandering import cruise, heading, redraw
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, norm, plus, times
from subsea.kernels import kernel
from subsea.state import (
    BRIGHTNESS,
    COLD,
    DARKNESS,
    LEAVE,
    PREDATOR,
    WARMTH,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.habits import (
    brightness_above,
    dusk_of,
    mild_of,
    share_of_light,
    share_of_warmth,
    wish,
)
from subsea.state.schools import known_by

CLIMB = 0.8  # how steeply a fish leaves upward or downward
BRISK = 0.7  # share of the fastest speed
BACK = 1.5  # weight of the way back to its school
DISLIKES = 0.03, 0.6  # least desire, above calm schooling, and how it grows with the discomfort
TOLERANCE = 0.02  # discomfort that a fish bears ...
BEYOND = 0.06  # ... and how far beyond its threshold a fish goes that leaves


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Desire to leave where light or temperature is disliked, above calm schooling (Tu fig. 7.4).

    It grows with the discomfort. Predators do not mind.
    """
    least, growth = DISLIKES
    for i in who:
        out[i] = 0.0
        if minds.kind[i] != PREDATOR:
            upset = abs(wanted_rise(minds, i, sea, nature))
            if upset > TOLERANCE:
                out[i] = least + growth * min(upset, 1.0)


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Wander upward to light and warmth, or downward to darkness and cold, with the school."""
    for i in who:
        if minds.held[i] == 0.0 and minds.errand[i] <= 0.0:
            redraw(fishes, minds, i, sea, clock)  # the last one lies where it is leaving
        toward = heading(fishes, minds, i, sea, clock)
        if minds.schools[i]:
            toward = _common_course(fishes, minds, i, toward)
            back = way_back(fishes, minds, i, 1.0, toward, clock.tick * clock.dt)[0]
            toward = plus(toward, times(BACK, back))
        rise = wanted_rise(minds, i, sea, nature)
        steep = CLIMB if rise > 0.0 else -CLIMB if rise < 0.0 else toward[2]
        set_urge(minds, i, (toward[0], toward[1], steep))
        fishes.goal_speed[i] = max(cruise(fishes, minds, i, clock), BRISK)


@kernel
def wanted_rise(minds: Minds, i: int, sea: Sea, nature: Nature) -> float:
    """Discomfort of fish i: above 0 if its habits lead upward, below 0 if downward.

    The shares of the sea's range of light and warmth by which the place misses its thresholds;
    opposite wishes cancel. A fish that leaves goes some way beyond.
    """
    beyond = BEYOND if minds.intention[i] == LEAVE else 0.0
    climate, rise = sea.climate, 0.0
    light = wish(minds, i, BRIGHTNESS, DARKNESS)
    if light != 0.0:
        # Its habit is about the waters of this hour: nobody leaves them because night falls.
        share = share_of_light(float(minds.light[i]) / brightness_above(sea), climate)
        rise += light * max(light * (dusk_of(minds, i, nature) - share) + beyond, 0.0)
    warmth = wish(minds, i, WARMTH, COLD)
    if warmth != 0.0 and climate[0] != climate[1]:
        share = share_of_warmth(float(minds.temperature[i]), climate)
        warmer = warmth if climate[0] > climate[1] else -warmth  # 1: it is up where it likes it
        rise += warmer * max(warmth * (mild_of(minds, i, nature) - share) + beyond, 0.0)
    return rise


@kernel
def _common_course(fishes: Fishes, minds: Minds, i: int, toward: Vector) -> Vector:
    """Mean of the way of fish i and the headings of its school, so that they leave together."""
    course, count = toward, 0
    for j in minds.neighbour[i]:
        if j < 0:
            break
        if minds.schools[j] and known_by(minds, j) == known_by(minds, i):
            course = plus(course, x_axis(fishes.orientation[j]))
            count += 1
    return times(1.0 / max(norm(course), 1e-6), course) if count > 0 else toward
