"""Feeding on stone: fishes graze turf and pick polyps, sponges and rubble, with the nose down.

A feeding fish swims to a place before its food, turns its snout to the surface by its pectoral
fins, bites, backs off a little and bites again. A place that is bare is left for the next one.
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase, mouth_of, set_urge
from subsea.behavior.hunting import EAGER
from subsea.behavior.wandering import wander
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, times, unit, vector
from subsea.kernels import kernel
from subsea.state import GRAZE, HUNGER, Clock, Fishes, Minds, Nature, Sea

STILL_KEEN = 0.4  # share of `keen` below which a fish that feeds stops
BROWSING = 0.65  # desire to feed of a fish that is hardly hungry: more than curiosity
LEAN = 0.75  # tangent of the angle by which the body leans from the surface's normal
BEFORE_BL = 0.55  # distance of the snout from its food before and between bites
NEAR_BL = 4.0  # distance within which a fish turns to its food, ...
SLOWS_BL = 8.0  # ... and over which it slows down before
SHELL_BL = 1.6  # distance within which it enters the shell of free water around stone
BITE_BL = 0.13  # farthest food that a snout reaches
OPEN_BL = 0.35  # distance at which the mouth opens
ARRIVES, CREEPS = 0.4, 0.13  # fastest and slowest approach, shares of the fastest speed
BACKS = -0.16  # speed of a fish that backs off
AIMED_COS = np.cos(np.radians(35.0))  # angle from its food beyond which a fish turns first
STRAIGHT = 0.5  # distance aside over that ahead within which a fish goes straight to its food
BACK_BL = 0.27  # distance to which it backs off
THERE_BL = 0.15  # distance from its place before the food within which it is there
ROUND_BL = 0.3  # distance within which it leans to where it heads
PAUSE_S = (0.3, 1.1)  # from a bite to the next attempt
SLACK_CM = 1.0  # depth below its food that a snout may reach
GIVES_UP_S = 9.0  # without a bite at a place; afar from it ...
AFAR = 0.35  # ... this share of the time counts
BITE = 0.2  # share of a place's stock that a bite takes
BARE = 0.3  # stock at which a place is left
BITE_S = 40.0  # of digestion that a bite covers: fishes feed for a third of their time
PAUSE_PURPOSE = np.int64(121)  # key of the random numbers


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Hunger, where it exceeds `keen` and food on stone is in sight."""
    for i in who:
        if minds.site[i] < 0:
            out[i] = 0.0
            continue
        hunger = minds.mental[i, HUNGER]
        least = nature.keen * (STILL_KEEN if minds.intention[i] == GRAZE else 1.0)
        out[i] = max(hunger, EAGER * nature.keen) if hunger > least else 0.0


@kernel
def browsing_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """A wish to browse while perception offers food on stone and nothing is more urgent."""
    for i in who:
        out[i] = BROWSING if minds.site[i] >= 0 else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Come to the food, turn to it, and bring the snout to the surface."""
    for i in who:
        s = minds.site[i]
        if s < 0:
            wander(fishes, minds, i, sea, clock)
            continue
        length, place = float(fishes.length[i]), vector(sea.site_place[s])
        ahead = x_axis(fishes.orientation[i])
        toward = minus(place, mouth_of(fishes, i))
        far = norm(toward)
        lie = attitude(toward if far > ROUND_BL * length else ahead, vector(sea.site_normal[s]))
        minds.peck[i] -= (AFAR if far > NEAR_BL * length else 1.0) * minds.pause[i]
        if minds.peck[i] < -GIVES_UP_S:
            minds.site[i], minds.peck[i] = -1, 0.0
        if far > NEAR_BL * length:
            chase(fishes, minds, i, minus(place, times(BEFORE_BL * length, lie)), ZERO)
            slow = ARRIVES + (far / length - NEAR_BL) / SLOWS_BL
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(slow))
            continue
        fishes.close[i] = True
        if far < SHELL_BL * length:
            fishes.shell[i] = sea.site_depth[s] + SLACK_CM
        if minds.peck[i] > 0.0:
            set_urge(minds, i, lie)
            fishes.goal_speed[i] = BACKS if far < BACK_BL * length else 0.0
            continue
        along = dot(toward, lie)
        aside = norm(minus(toward, times(along, lie)))
        if along > 0.0 and (aside < STRAIGHT * along or far < BACK_BL * length):
            _reach(fishes, minds, i, toward, far)
        else:
            _align(fishes, minds, i, lie, minus(toward, times(BEFORE_BL * length, lie)))


@kernel
def _reach(fishes: Fishes, minds: Minds, i: int, toward: Vector, far: float) -> None:
    """Creep straight to the food, `far` cm away along `toward`, once the body points there."""
    length, limit = float(fishes.length[i]), min(far / fishes.length[i], 1.0) * ARRIVES
    pointed = dot(x_axis(fishes.orientation[i]), toward) / max(far, 1e-6)
    set_urge(minds, i, toward)
    if far < OPEN_BL * length:
        fishes.gape[i] = 1.0
    if pointed > AIMED_COS:
        fishes.goal_speed[i] = max(limit, CREEPS)
    else:
        fishes.goal_speed[i] = BACKS if far < BACK_BL * length else 0.0


@kernel
def _align(fishes: Fishes, minds: Minds, i: int, lie: Vector, way: Vector) -> None:
    """Come to the place before the food, `way` cm from the snout, and turn to lie there."""
    length, gap = float(fishes.length[i]), norm(way)
    behind = dot(x_axis(fishes.orientation[i]), way) < 0.0
    if gap < THERE_BL * length or behind:
        set_urge(minds, i, lie)
        fishes.goal_speed[i] = BACKS if gap > THERE_BL * length else 0.0
    else:
        set_urge(minds, i, way)
        fishes.goal_speed[i] = max(min(gap / length, 1.0) * ARRIVES, CREEPS)


@kernel
def attitude(heading: Vector, normal: Vector) -> Vector:
    """Unit vector along which a body lies that feeds at a surface with this outward `normal`.

    It leans from the normal downward and to the bearing of `heading`.
    """
    level = np.sqrt(heading[0] * heading[0] + heading[1] * heading[1])
    share = 1.0 / max(level, 1e-6)
    along = (share * heading[0], share * heading[1], -1.0)
    along = minus(along, times(dot(along, normal), normal))
    size = norm(along)
    lean = times(LEAN / size, along) if size > 1e-3 else ZERO
    return unit(minus(lean, normal))


@kernel
def bite(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Let all snouts that reach their food bite; runs every tick, one fish after the other.

    A bite counts as the food of BITE_S seconds, whatever the size of the fish.
    """
    now = clock.tick * clock.dt
    for i in range(len(minds.intention)):
        s = minds.site[i]
        if minds.intention[i] != GRAZE or s < 0 or minds.peck[i] > 0.0 or not fishes.close[i]:
            continue
        gap = norm(minus(vector(sea.site_place[s]), mouth_of(fishes, i)))
        if gap > BITE_BL * fishes.length[i] or sea.stock[s] <= 0.0 or not fishes.alive[i]:
            continue
        sea.stock[s] = max(sea.stock[s] - np.float32(BITE), np.float32(0.0))
        feed(minds, i, BITE_S, now)
        minds.fatigue[GRAZE, i] = 0.0
        low, high = PAUSE_S
        share = uniform(clock.seed, i, clock.tick, PAUSE_PURPOSE)
        minds.peck[i] = low + (high - low) * share
        if sea.stock[s] < BARE:
            minds.site[i], minds.peck[i] = -1, 0.0


@kernel
def feed(minds: Minds, i: int, covers: float, now: float) -> None:
    """Give fish i what it digests in `covers` s; what it has digested until `now` is settled."""
    left = max(1.0 - minds.digestion[i] * (now - minds.last_meal[i]), 0.0)
    meals = covers * minds.digestion[i] * minds.appetite[i]
    minds.eaten[i] = min(minds.eaten[i] * left + meals, minds.appetite[i])
    minds.last_meal[i] = now
