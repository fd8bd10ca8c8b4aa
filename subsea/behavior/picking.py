"""Picking: a school that stays, and fishes of an anemone, take plankton too small to be drawn.

Planktivores of reefs, as fusiliers and silversides, feed for much of the day on copepods and other
animals of a millimetre or less, hundreds in each cubic metre (Hobson 1991). A fish slows down,
turns to one, snaps at it, and catches up with its school. A fish of an anemone darts to one after
the other in the current above, as clownfishes do for most of their food (Fautin and Allen 1992).
"""

import math

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase, set_urge
from subsea.behavior.grazing import feed
from subsea.behavior.moods import travels
from subsea.behavior.schooling import has_school, straggles, swim_along
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import BATHES, EAT, HUNGER, Clock, Fishes, Minds, Nature, Sea

PICKING = 0.05  # desire: more than calm schooling, less than curiosity
PECK_S = 1.2  # from one attempt to the next
OFTEN = 0.6, 0.8  # share of attempts in a school that stays, of a sated and of a famished fish
SLOW = 0.18  # share of the fastest speed of a fish that picks
ASIDE_RAD, ABOVE = np.radians(25.0), 0.2  # range of the way to the prey: angle, and sine upward
COMPANY = 0.8  # weight of schooling meanwhile
SNAPS = 0.7  # part of an attempt at which the mouth opens
COVERS_S = 8.0  # of digestion that a catch covers
DARTS_S = 1.3  # from one copepod above an anemone to the next
DARTS_ASIDE_CM, DARTS_OVER_CM = 35.0, (12.0, 45.0)  # where they are, from the anemone
DARTS = 0.45  # fastest speed there, share of the fastest
COVERS = 4.0  # seconds of digestion that a second there covers
DARTS_PURPOSE = np.int64(168)  # keys of the random numbers
PECK_PURPOSE, SIDE_PURPOSE, RISE_PURPOSE = np.int64(170), np.int64(171), np.int64(172)


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """A wish to pick at times, the more often the more the school stays, and by daylight."""
    now, (least, most) = clock.tick * clock.dt, OFTEN
    for i in who:
        out[i] = 0.0
        stays = (1.0 - travels(minds, i)) * sea.sky[1]
        if stays <= 0.0 or minds.led[i] or not has_school(minds, i, now):
            continue
        often = stays * (least + (most - least) * float(minds.mental[i, HUNGER]))
        attempt = np.int64(_attempts(fishes, i, now, PECK_S))
        if uniform(clock.seed, i, attempt, PECK_PURPOSE) < often:
            out[i] = 0.0 if straggles(fishes, minds, i, now) else PICKING


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Slow down, turn to the prey and snap at it, in company."""
    now = clock.tick * clock.dt
    for i in who:
        swim_along(i, fishes, minds, sea, nature, clock)
        attempts = _attempts(fishes, i, now, PECK_S)
        attempt = np.int64(attempts)
        part = attempts - attempt
        side = 2.0 * uniform(clock.seed, i, attempt, SIDE_PURPOSE) - 1.0
        turn = ASIDE_RAD * side * (1.0 - part)
        rise = ABOVE * (2.0 * uniform(clock.seed, i, attempt, RISE_PURPOSE) - 1.0)
        ahead, urge = x_axis(fishes.orientation[i]), vector(minds.urge[i])
        c, s = math.cos(turn), math.sin(turn)
        aim = (c * ahead[0] - s * ahead[1], s * ahead[0] + c * ahead[1], rise)
        set_urge(minds, i, plus(aim, times(COMPANY / max(norm(urge), 1e-6), urge)))
        fishes.goal_speed[i] = SLOW
        if part >= SNAPS:
            fishes.gape[i] = 1.0
            if part - minds.pause[i] / PECK_S < SNAPS:
                feed(minds, i, COVERS_S, now)


@kernel
def picks_at_home(minds: Minds, i: int) -> bool:
    """True if fish i picks small plankton above its anemone."""
    return bool(minds.ways[i] & BATHES and minds.cover[i] >= 0)


@kernel
def pick_at_home(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> float:
    """Dart to one copepod after the other above the anemone of fish i; returns its distance."""
    now = clock.tick * clock.dt
    attempt = np.int64(_attempts(fishes, i, now, DARTS_S))
    angle = 2.0 * np.pi * uniform(clock.seed, i, attempt, DARTS_PURPOSE)
    share = uniform(clock.seed, i, attempt + (1 << 40), DARTS_PURPOSE)
    low, high = DARTS_OVER_CM
    aside = DARTS_ASIDE_CM * np.sqrt(share)
    off = (aside * np.cos(angle), aside * np.sin(angle), low + (high - low) * (1.0 - share))
    distance = chase(fishes, minds, i, plus(vector(sea.site_place[minds.cover[i]]), off), ZERO)
    fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(DARTS))
    feed(minds, i, COVERS * float(minds.pause[i]), now)
    minds.fatigue[EAT, i] = 0.0
    return distance


@kernel
def _attempts(fishes: Fishes, i: int, now: float, period_s: float) -> float:
    """Number of attempts of fish i so far, one in `period_s`; each fish has its own moments."""
    return now / period_s + float(fishes.identity[i])
