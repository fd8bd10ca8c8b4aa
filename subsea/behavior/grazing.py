"""Feeding on stone: fishes graze turf and pick polyps, sponges and rubble, with the nose down.

A feeding fish swims to a place before its food and turns its snout to the surface. It holds this
place by its fins, strikes, bites and falls back, many times. A place that is bare is left for the
next one. Hunger begins a meal, and a full fish ends it: in between it does something else.
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase, mouth_of
from subsea.behavior.hunting import EAGER
from subsea.behavior.manoeuvring import careful, scull, steer
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, times, unit, vector
from subsea.kernels import kernel
from subsea.state import GRAZE, HUNGER, Clock, Fishes, Minds, Nature, Sea

LEAN = 0.75  # tangent of the angle by which the body leans from the surface's normal
BEFORE_BL = 0.3  # distance of the snout from its food before and between bites
NEAR_BL = 4.0  # distance within which a fish turns to its food, ...
SLOWS_BL = 8.0  # ... and over which it slows down before
STEEP = 0.4  # sine of the steepest way that a fish swims to its food; it rows down a steeper one
SHELL_BL = 1.6  # distance within which it enters the shell of free water around stone
HOVERS_BL = 0.7  # distance from its place before the food within which it hovers
SCULLS_BL_S, FIRM = 0.45, 2.0  # fastest sculling while it hovers; factor on its gain, in currents
BITE_BL = 0.13  # farthest food that a snout reaches
OPEN_BL = 0.35  # distance at which the mouth opens
ARRIVES = 0.4  # fastest speed at which it arrives, share of the fastest
AIMED_COS = np.cos(np.radians(35.0))  # angle from its attitude within which it strikes
PAUSE_S = (0.8, 2.0)  # from a bite to the next strike, by its identity
SLACK_CM = 1.0  # depth below its food that a snout may reach
GIVES_UP_S = 6.0  # without a bite at a place; afar from it ...
AFAR = 0.35  # ... this share of the time counts
BITE = 0.1  # share of a place's stock that a bite takes
BARE = 0.3  # stock at which a place is left
BITE_S = 18.0  # of digestion that a bite covers: a meal is two bites or more


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Hunger, while perception offers food on stone: from `keen` on, until the fish is full."""
    for i in who:
        hungry = max(float(minds.mental[i, HUNGER]), EAGER * nature.keen)
        out[i] = hungry if minds.site[i] >= 0 else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Come to the food, turn to it, and hold the place before it."""
    for i in who:
        s = minds.site[i]
        length = float(fishes.length[i])
        toward = minus(vector(sea.site_place[s]), mouth_of(fishes, i))
        far = norm(toward)
        minds.peck[i] -= (AFAR if far > NEAR_BL * length else 1.0) * minds.pause[i]
        if minds.peck[i] < -GIVES_UP_S:
            minds.site[i], minds.peck[i] = -1, 0.0
        lie = attitude(toward, vector(sea.site_normal[s]))
        way = minus(toward, times(BEFORE_BL * length, lie))
        if far > NEAR_BL * length:
            chase(fishes, minds, i, minus(vector(sea.site_place[s]), minus(toward, way)), ZERO)
            slow = ARRIVES + (far / length - NEAR_BL) / SLOWS_BL
            slow = ARRIVES if -way[2] > STEEP * norm(way) else slow
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(slow))
            continue
        fishes.close[i] = True
        if far < SHELL_BL * length:
            fishes.shell[i] = sea.site_depth[s] + SLACK_CM
        if far < OPEN_BL * length and minds.peck[i] <= 0.0:
            fishes.gape[i] = 1.0
        if hovers(fishes, i, far):
            steer(fishes, minds, i, _lie_of(fishes, minds, i, sea))
            fishes.goal_speed[i] = 0.0
        else:
            turn = steer(fishes, minds, i, way)
            gap = min(norm(way) / length, 1.0)
            fishes.goal_speed[i] = ARRIVES * careful(turn) * gap


@kernel
def hovers(fishes: Fishes, i: int, far: float) -> bool:
    """True if fish i, `far` cm from its food, moves by its fins alone."""
    return far < (BEFORE_BL + HOVERS_BL) * fishes.length[i]


@kernel
def _lie_of(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> Vector:
    """Unit vector along which hovering fish i lies: on its bearing, toward its food."""
    ahead = x_axis(fishes.orientation[i])
    return attitude(ahead, vector(sea.site_normal[minds.site[i]]))


@kernel
def hold(fishes: Fishes, minds: Minds, sea: Sea) -> None:
    """Let all fishes that hover at their food scull to their place, or strike; runs every tick."""
    for i in range(len(minds.intention)):
        if minds.intention[i] != GRAZE or minds.site[i] < 0 or not fishes.close[i]:
            continue
        toward = minus(vector(sea.site_place[minds.site[i]]), mouth_of(fishes, i))
        if not hovers(fishes, i, norm(toward)):
            continue
        lie = _lie_of(fishes, minds, i, sea)
        back = 1.0 if dot(x_axis(fishes.orientation[i]), lie) < AIMED_COS else 0.0
        if minds.peck[i] > 0.0:
            # It swings back and forth without a jerk.
            back = np.sin(np.pi * min(minds.peck[i] / _pause_of(fishes, i), 1.0)) ** 2
        before = times(back * BEFORE_BL * float(fishes.length[i]), lie)
        scull(fishes, i, times(FIRM, minus(toward, before)), SCULLS_BL_S)


@kernel
def _pause_of(fishes: Fishes, i: int) -> float:
    """Seconds from a bite of fish i to its next strike."""
    low, high = PAUSE_S
    return low + (high - low) * float(fishes.identity[i])


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
        minds.peck[i] = _pause_of(fishes, i)
        if sea.stock[s] < BARE:
            minds.site[i], minds.peck[i] = -1, 0.0


@kernel
def feed(minds: Minds, i: int, covers: float, now: float) -> None:
    """Give fish i what it digests in `covers` s; what it has digested until `now` is settled."""
    left = max(1.0 - minds.digestion[i] * (now - minds.last_meal[i]), 0.0)
    meals = covers * minds.digestion[i] * minds.appetite[i]
    minds.eaten[i] = min(minds.eaten[i] * left + meals, minds.appetite[i])
    minds.last_meal[i] = now
