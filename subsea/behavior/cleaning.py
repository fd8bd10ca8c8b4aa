"""Cleaning: a cleaner holds a station; fishes that itch pose there and are picked clean.

A client stands still with its head up and its fins spread. The cleaner inspects it from head to
tail. A jolt of the client ends it, and the next one has its turn (Losey 1972). A cleaner that likes
the submarine picks at its window when no client poses; the itch is then its own.
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase, mouth_of, set_urge
from subsea.behavior.curious import BACKS_OFF
from subsea.behavior.grazing import feed
from subsea.behavior.manoeuvring import careful, steer
from subsea.behavior.steering import BODY_BL, CLEARANCE_CM, is_before_window
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import rotate, x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, times, unit, vector
from subsea.kernels import kernel
from subsea.state import (
    CLEANS,
    HULL_CM,
    NO_COURTSHIP,
    NOBODY,
    POSE,
    SUBMARINE,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.habits import is_pleasant
from subsea.state.wants import ITCH_BEGINS, ITCH_ENDS

ITCH_S = (800.0, 1400.0)  # from one cleaning until a fish itches fully, by its identity
GLASS_S = 150.0  # likewise of a cleaner, from one visit to the window until it longs for the next
WAITS_S = 15.0  # for the cleaner, which may be busy
POSING = 0.67  # desire to be cleaned: more than curiosity
COMES = 0.6  # fastest speed of clients and cleaners on their way, share of the fastest
RING_CM, RING_BL = 20.0, 1.2  # clients stand this far from the station: constant, and per length
THERE_BL = 0.8  # distance from that place at which a client poses
HEAD_UP = np.tan(np.radians(48.0))  # slope of a body that poses
CLEANING, HOLDING = 0.9, 0.25  # desire to clean, and to hold the station
CYCLE_S, HOLDS = 80.0, 0.6  # share of a cycle in which a cleaner without a client stays there
NEAR_BL = 2.0  # distance of an idle cleaner from its station
PASS_S = 7.0  # from head to tail and back
# Distance of the window, and the angles within which a cleaner moves before it.
PANE_CM, PANE_ASIDE, PANE_UP = HULL_CM + 2.5 * CLEARANCE_CM, 0.25, 0.1
GLASS_PASS_S = 14.0  # from side to side of the window and back
TOUCH_BL = 0.5  # distance of the snout from the skin at which it picks, by the cleaner's length
PICKS_HZ = 1.2
CLEANED_S = 9.0  # of picking take away the whole itch
JOLT_S = 16.0  # mean time until a client jolts
GLIDES = 0.45  # fastest speed of a cleaner at work, share of its fast swim ...
ARRIVES_BL, GENTLY = 5.0, 0.25  # ... and from this distance on, by its length; before a window
MEALS_S = 3.0  # digestion that a second of picking covers, s
JOLT_PURPOSE = np.int64(165)  # key of the random numbers


@kernel
def posing_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """The itch of fishes that know the station of a cleaner that is free; it grows with time."""
    low, high = ITCH_S
    for i in who:
        out[i] = 0.0
        if minds.ways[i] == 0:
            continue
        full = low + (high - low) * fishes.identity[i]
        full = GLASS_S if minds.ways[i] & CLEANS else full
        minds.itch[i] = min(minds.itch[i] + minds.pause[i] / full, 1.0)
        c = minds.cleaner[i]
        if c == NOBODY or minds.errand[i] > 0.0:
            continue
        poses = minds.intention[i] == POSE
        # Where another one is cleaned, it goes on with what it does, and comes again.
        free = poses or minds.client[c] in (NOBODY, i)
        if free and minds.itch[i] > (ITCH_ENDS if poses else ITCH_BEGINS):
            out[i] = POSING


@kernel
def pose(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Come to a place around the station, and stand there with the head up."""
    for i in who:
        c = minds.cleaner[i]
        if minds.held[i] > WAITS_S and minds.client[c] != i:
            minds.itch[i] = 0.9 * ITCH_ENDS  # it gives up for now
        spot = plus(vector(minds.home[c]), _place_in_ring(fishes, i))
        toward = minus(spot, vector(fishes.position[i]))
        ahead = x_axis(fishes.orientation[i])
        if norm(toward) > THERE_BL * fishes.length[i]:
            chase(fishes, minds, i, spot, ZERO)
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(COMES))
            continue
        level = max(np.sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1]), 1e-3)
        set_urge(minds, i, (ahead[0] / level, ahead[1] / level, HEAD_UP))
        fishes.goal_speed[i] = 0.0


@kernel
def _place_in_ring(fishes: Fishes, i: int) -> Vector:
    """Return the place of client i relative to the station, cm. Each has its own direction."""
    turn = 2.0 * np.pi * float(fishes.identity[i])
    away = RING_CM + RING_BL * float(fishes.length[i])
    return away * np.cos(turn), away * np.sin(turn), 0.3 * away


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """The wish of a cleaner to clean a fish that poses."""
    for i in who:
        free = minds.client[i] != NOBODY and minds.errand[i] <= 0.0
        out[i] = CLEANING if free and minds.courtship[i] == NO_COURTSHIP else 0.0


@kernel
def holding_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """The wish of a cleaner to hold a station that it likes, for a part of each cycle."""
    for i in who:
        out[i] = 0.0
        at_work = minds.ways[i] & CLEANS and is_pleasant(minds, i, minds.home[i, 2])
        if at_work and minds.errand[i] <= 0.0:
            cycle = clock.tick * clock.dt / CYCLE_S + float(fishes.identity[i])
            out[i] = HOLDING if cycle % 1.0 < HOLDS else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Inspect the client from head to tail, or hover at the station.

    It writes the itch of the client.
    """
    now = clock.tick * clock.dt
    for i in who:
        j = np.int64(minds.client[i])
        length = float(fishes.length[i])
        if j == NOBODY:
            gap = chase(fishes, minds, i, vector(minds.home[i]), ZERO)
            most = 0.5 * GLIDES if gap < NEAR_BL * length else COMES
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(most))
            continue
        at_glass = j == SUBMARINE
        skin = _glass(sea, i, now) if at_glass else _skin(fishes, i, j, now)
        toward = minus(skin, mouth_of(fishes, i))
        gap = norm(toward)
        keeps_off = at_glass and _keeps_off(fishes, minds, i, sea)
        if not keeps_off and gap > NEAR_BL * length:
            chase(fishes, minds, i, skin, ZERO if at_glass else vector(fishes.velocity[j]))
            most = GLIDES if at_glass and gap < ARRIVES_BL * length else COMES
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(most))
        elif not keeps_off:
            turn = steer(fishes, minds, i, toward)
            fastest = GENTLY if at_glass else GLIDES
            fishes.goal_speed[i] = fastest * careful(turn) * min(gap / length, 1.0)
        if gap > TOUCH_BL * length:
            continue
        fishes.gape[i] = 0.5 + 0.5 * np.sin(2.0 * np.pi * PICKS_HZ * now)
        c = i if at_glass else j
        minds.itch[c] = max(minds.itch[c] - np.float32(minds.pause[i] / CLEANED_S), np.float32(0.0))
        feed(minds, i, MEALS_S * float(minds.pause[i]), now)
        jolts = uniform(clock.seed, c, clock.tick, JOLT_PURPOSE) < minds.pause[i] / JOLT_S
        if jolts and not at_glass:
            minds.itch[c] = min(minds.itch[c], np.float32(0.5 * ITCH_ENDS))


@kernel
def _keeps_off(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> bool:
    """Let cleaner i, if it is too near to the hull, back off, or turn and leave."""
    toward = minus(vector(sea.submarine[:3]), vector(fishes.position[i]))
    ahead = is_before_window(vector(fishes.position[i]), sea)
    body = BODY_BL * float(fishes.length[i])
    if norm(toward) > (PANE_CM + 0.5 * body if ahead else HULL_CM + body):
        return False
    faces = ahead and dot(toward, x_axis(fishes.orientation[i])) > 0.0
    set_urge(minds, i, toward if faces else times(-1.0, toward))
    fishes.goal_speed[i] = BACKS_OFF if faces else GLIDES
    return True


@kernel
def _glass(sea: Sea, i: int, now: float) -> Vector:
    """The point of the window at which cleaner i is at a time."""
    gaze = vector(sea.submarine[6:9])
    turn = 2.0 * np.pi * now / GLASS_PASS_S + i
    aside, up = PANE_ASIDE * np.sin(turn), PANE_UP * np.sin(0.6 * turn)
    way = (gaze[0] - aside * gaze[1], gaze[1] + aside * gaze[0], gaze[2] + up)
    return plus(vector(sea.submarine[:3]), times(PANE_CM, unit(way)))


@kernel
def _skin(fishes: Fishes, i: int, j: int, now: float) -> Vector:
    """The point of the skin of fish j at which cleaner i is at a time, on its side of the body."""
    wave = abs(2.0 * ((now / PASS_S) % 1.0) - 1.0)
    q = fishes.orientation[j]
    along = float(fishes.snout[j]) - (0.1 + 0.7 * wave) * float(fishes.length[j])
    side = rotate(q, (0.0, 0.0, 1.0))
    off = minus(mouth_of(fishes, i), vector(fishes.position[j]))
    wide = 0.5 * float(fishes.girth[j, 1]) * (1.0 if dot(off, side) > 0.0 else -1.0)
    return plus(vector(fishes.position[j]), plus(times(along, x_axis(q)), times(wide, side)))
