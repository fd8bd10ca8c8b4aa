"""Curiosity: pacifists come to the submarine's window and watch for a while (SMC §9.1)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase
from subsea.behavior.manoeuvring import steer
from subsea.behavior.wandering import is_at_home
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import CURIOUS, PACIFIST, SUBMARINE, Clock, Fishes, Minds, Nature, Sea
from subsea.state.feelings import feeling_for

INTEREST = 0.6
FOND = 0.2  # liking for the submarine with which any fish comes to it
SATED_S = (25.0, 40.0)  # how long a fish watches, by its identity
FORGETS = 0.4  # s of watching forgotten per second: a minute or more until the next look
FRESH_S = 2.0
SHY_S = 40.0  # fatigue with which a fish twice as timid as usual begins: it does not come at once
SIGHT_COS = np.cos(np.radians(150.0))  # limit of the field of view
WATCH_CM = 110.0  # from the middle of the hull to the snout of a watching fish
FAN_RAD, TIERS_CM = np.radians(70.0), 90.0  # the crowd's width and height before the window
THERE_BL, CLOSE = 2.0, 0.75  # distances at which it has arrived, and at which it backs off
WATCHES, BACKS_OFF = 0.05, -0.4  # shares of the fastest speed


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Interest of pacifists that see the submarine and have not watched it enough lately.

    Timid ones come only when it is near, and take longer until the next look. Any fish comes that
    likes it.
    """
    hull = vector(sea.submarine[:3])
    for i in who:
        looks = minds.intention[i] == CURIOUS
        seen = minds.fatigue[CURIOUS, i]
        low, high = SATED_S
        enough = low + (high - low) * fishes.identity[i] if looks else FRESH_S
        if not looks and seen > 0.0:
            # Fatigue falls by a second per second: slow that down.
            forgets = min(FORGETS / float(minds.timidity[i]), 1.0)
            minds.fatigue[CURIOUS, i] += (1.0 - forgets) * minds.pause[i]
        toward = minus(hull, vector(fishes.position[i]))
        ahead = x_axis(fishes.orientation[i])
        liking = feeling_for(minds, i, SUBMARINE)
        drawn = minds.kind[i] == PACIFIST or liking > FOND
        drawn = drawn and seen < enough and is_at_home(minds, i, hull)
        reach = nature.curiosity_cm * (1.0 + liking) / float(minds.timidity[i])
        out[i] = INTEREST if drawn and _sees(toward, ahead, reach) else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Come to the fish's own place before the window, keep pace with it and face it."""
    hull, pace = vector(sea.submarine[:3]), vector(sea.submarine[3:6])
    for i in who:
        spot = plus(hull, place_before(sea, fishes.length[i], fishes.identity[i]))
        gap = chase(fishes, minds, i, spot, pace)
        toward = minus(hull, vector(fishes.position[i]))
        near = norm(toward) - (WATCH_CM + 0.5 * fishes.length[i])
        if gap < THERE_BL * fishes.length[i] or near < 0.0:
            steer(fishes, minds, i, toward)
            too_close = norm(toward) < CLOSE * (WATCH_CM + 0.5 * fishes.length[i])
            fishes.goal_speed[i] = BACKS_OFF if too_close else WATCHES


@kernel
def place_before(sea: Sea, length: float, identity: float) -> Vector:
    """Place where a fish watches, cm from the middle of the hull: spread by length and identity."""
    gaze = vector(sea.submarine[6:9])
    aside = FAN_RAD * (identity - 0.5)
    c, s = np.cos(aside), np.sin(aside)
    ahead = (c * gaze[0] - s * gaze[1], s * gaze[0] + c * gaze[1], gaze[2])
    tier = TIERS_CM * ((7.0 * identity) % 1.0 - 0.5)
    return plus(times(WATCH_CM + length, ahead), (0.0, 0.0, tier))


@kernel
def _sees(toward: Vector, ahead: Vector, reach: float) -> bool:
    """True if a point at `toward` (cm) is within `reach` cm and not behind the fish."""
    distance = norm(toward)
    return distance < reach and dot(ahead, toward) > SIGHT_COS * distance
