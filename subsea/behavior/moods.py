"""Moods of a schooling fish: how feeding and fear change the rules of its school.

One number tells a fish of a school that stays to feed (-1) from one that travels (0) and one that
is alarmed (1). A school alternates between staying and travel. A fish takes over the mood of its
neighbours, so alarm spreads faster than a predator swims (Treherne and Foster, Anim. Behav. 29:911,
1981). Alarmed schools are dense and polarised; feeding ones are loose and in disorder (Pitcher and
Parrish 1993).
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.angles import sine_cosine
from subsea.geometry.noise import uniform
from subsea.kernels import kernel
from subsea.state import FEAR, Clock, Fishes, Minds, Nature
from subsea.state.school_rules import CONTAGION, MOODS, NOISE_S, REST
from subsea.state.schools import known_by

VIGILANT = 0.4  # share of the fear of an alarmed fish at which it begins to be alarmed
ROUSED_S, CALMED_S = 0.2, 6.0  # time constants: of alarm, and of the way back to ease
STAYS_S = 1.5  # likewise between travel and feeding
# Change of alignment, noise and spacing: factors at full alarm, and while feeding.
ALARMED, FEEDING = (2.5, 0.15, 0.7), (0.8, 1.2, 1.05)
FEEDING_SPEED = 0.7  # factor on the speed of a school that feeds
LEAST_TRAVEL = 0.4  # activity of a school that travels slowly
REST_S = 10.0  # a school decides this often whether to stay ...
SETTLES_S = 4.0  # ... takes this long to stop or set out ...
SPREAD_S = 3.0  # ... and its fishes do so one after the other within this time
PACE_TIMES = 2.0  # time constant of the speed's noise, over that of the heading's
REST_PURPOSE = np.int64(160)  # keys of the random numbers
HEADING_PURPOSE, PACE_PURPOSE = np.int64(161), np.int64(162)


class Temper(NamedTuple):
    """Factors by which a mood changes the rules of a fish."""

    alignment: float
    noise: float
    spacing: float
    speed: float
    alarm: float  # 0 at ease to 1


@kernel
def update_moods(who: Ints, fishes: Fishes, minds: Minds, nature: Nature, clock: Clock) -> None:
    """Ease `minds.mood` of the fishes `who` that school to what they feel, and to their company."""
    for i in who:
        if not minds.schools[i]:
            continue
        mood, dt = float(minds.mood[i]), float(minds.pause[i])
        feels = _feeling(fishes, minds, i, nature, clock)
        time_s = ROUSED_S if feels > max(mood, 0.0) else CALMED_S
        if max(feels, mood) <= 0.0:
            time_s = STAYS_S
        mood += (feels - mood) * min(dt / time_s, 1.0)
        rate = minds.rules[minds.school_rule[i], CONTAGION]
        if minds.neighbour[i, 0] >= 0:
            mood += (float(minds.company_mood[i]) - mood) * min(rate * dt, 1.0)
        minds.mood[i] = min(max(mood, -1.0), 1.0)


@kernel
def _feeling(fishes: Fishes, minds: Minds, i: int, nature: Nature, clock: Clock) -> float:
    """Compute the mood of fish i without company: -1 to feed, 0 to travel, 1 is alarm."""
    calm = VIGILANT * nature.alarmed
    alarm = (float(minds.mental[i, FEAR]) - calm) / max(nature.alarmed - calm, 1e-3)
    alarm = min(max(alarm, 0.0), 1.0)
    school = known_by(minds, i)
    if minds.led[i] or minds.errand[school] > 0.0:
        return alarm
    rest = minds.rules[minds.school_rule[i], REST]
    stays = 1.0 - travel_drive(i, school, rest, float(fishes.identity[i]), clock)
    return alarm - (1.0 - alarm) * stays


@kernel
def temper_of(minds: Minds, i: int, loose: float = 1.0) -> Temper:
    """Compute the factors by which the mood of fish i changes the rules of its school.

    `loose` is a factor on the distances of a fish at ease. Sociable fishes are closer.
    """
    share = minds.rules[minds.school_rule[i], MOODS]
    alarm = share * max(float(minds.mood[i]), 0.0)
    feeds = share * max(-float(minds.mood[i]), 0.0)
    spacing = 1.0 + (ALARMED[2] - 1.0) * alarm + (FEEDING[2] - 1.0) * feeds
    spacing *= loose ** (1.0 - alarm) / math.sqrt(float(minds.sociability[i]))
    return Temper(
        1.0 + (ALARMED[0] - 1.0) * alarm + (FEEDING[0] - 1.0) * feeds,
        1.0 + (ALARMED[1] - 1.0) * alarm + (FEEDING[1] - 1.0) * feeds,
        spacing,
        1.0 + (FEEDING_SPEED - 1.0) * feeds,
        alarm,
    )


@kernel
def travels(minds: Minds, i: int) -> float:
    """Share of the way from feeding in place, 0, to travel or flight, 1, of fish i."""
    return 1.0 + min(float(minds.mood[i]), 0.0)


@kernel
def travel_drive(i: int, school: int, rest: float, identity: float, clock: Clock) -> float:
    """Share of the way from staying, 0, to full travel, 1, of fish i in a school.

    A school draws it again every REST_S.
    """
    now = (clock.tick * clock.dt + SPREAD_S * identity) / REST_S
    period = int(now)
    level = _level(clock.seed, school, period, rest)
    if period == 0:
        return level
    before = _level(clock.seed, school, period - 1, rest)
    return before + (level - before) * min((now - period) * REST_S / SETTLES_S, 1.0)


@kernel
def _level(seed: int, school: int, period: int, rest: float) -> float:
    """Activity of a school in a period: 0 with the probability `rest`, else some travel."""
    drawn = uniform(seed, school, period, REST_PURPOSE)
    if rest <= 0.0:
        return 1.0
    if drawn < rest:
        return 0.0
    return LEAST_TRAVEL + (1.0 - LEAST_TRAVEL) * (drawn - rest) / (1.0 - rest)


@kernel
def deviate(minds: Minds, i: int, rule: Array, clock: Clock) -> None:
    """Advance the noise of fish i: an Ornstein-Uhlenbeck process of unit variance.

    The step since its last turn is exact, so the noise does not depend on how often it thinks.
    """
    for axis in range(2):
        purpose = HEADING_PURPOSE if axis == 0 else PACE_PURPOSE
        time_s = rule[NOISE_S] if axis == 0 else PACE_TIMES * rule[NOISE_S]
        kept = math.exp(-float(minds.pause[i]) / time_s)
        size = math.sqrt(max(1.0 - kept * kept, 0.0))
        # Two normal numbers from two even ones (Box and Muller 1958).
        far = math.sqrt(-2.0 * math.log(1.0 - uniform(clock.seed, i, clock.tick, purpose)))
        share = uniform(clock.seed, i, clock.tick + (1 << 40), purpose)
        sine, cosine = sine_cosine(2.0 * np.pi * share)
        if axis == 0:
            drawn = size * far * cosine, size * far * sine
            minds.deviation[i, 0] = kept * float(minds.deviation[i, 0]) + drawn[0]
            minds.deviation[i, 1] = kept * float(minds.deviation[i, 1]) + drawn[1]
        else:
            minds.deviation[i, 2] = kept * float(minds.deviation[i, 2]) + size * far * cosine
