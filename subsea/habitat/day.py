"""The day: the hour, and the daylight that fishes and pictures follow.

The hour is a function of the tick, so a dive that goes back in time goes back in the day.
"""

import math

from subsea.state import Clock, Nature, Sea

HOURS = 24.0
DAY_MINUTE_S = 60.0
# Sine of the sun's height, relative to noon, where twilight begins in the night and where an eye
# finds the day fully bright: the sun 15 degrees below the horizon and 37 degrees above it.
NIGHT, FULL_DAY = -0.25, 0.6
NIGHT_SIGHT = 0.45  # share of the range of sight that is left in moonlight


def hour_at(start: float, day_minutes: float, time_s: float) -> float:
    """Compute the hour of the day in [0, 24) at a time of a dive.

    A dive starts at the hour `start`, and a day takes `day_minutes`; the clock stands still if
    they are 0.
    """
    if day_minutes > 0.0:
        start += HOURS * time_s / (DAY_MINUTE_S * day_minutes)
    return start % HOURS


def daylight_at(hour: float) -> float:
    """Compute the brightness of daylight at an hour to an adapted eye: 0 at night to 1 at noon.

    It rises smoothly through the twilight, from 5 to 8:30 h, and falls from 15:30 to 19 h.
    """
    high = math.sin(math.pi * (hour - 6.0) / 12.0)
    share = min(max((high - NIGHT) / (FULL_DAY - NIGHT), 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


def move_sky(sea: Sea, start: float, day_minutes: float, clock: Clock) -> None:
    """Set `sea.sky` to the hour and the daylight of a tick; see `hour_at`."""
    hour = hour_at(start, day_minutes, clock.tick * clock.dt)
    sea.sky[0], sea.sky[1] = hour, daylight_at(hour)


def in_daylight(nature: Nature, daylight: float) -> Nature:
    """Return the constants of perception in this daylight, 0 to 1: fishes see less far in the dark.

    The reactive distance of fishes falls with the logarithm of light below that of a dull day.
    """
    share = NIGHT_SIGHT + (1.0 - NIGHT_SIGHT) * float(daylight)
    return nature._replace(vision_cm=share * nature.vision_cm)
