"""Avoid collisions with other fishes and with obstacles (Tu §7.8.1)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, unit, vector
from subsea.kernels import kernel
from subsea.state import (
    ASCEND,
    BATHE,
    DESCEND,
    ESCAPE,
    FEAR,
    LEFT,
    NOBODY,
    PICK,
    PREDATOR,
    PREY,
    RIGHT,
    RUSHING,
    SCHOOL,
    SEABED,
    SHELTER,
    SURFACE,
    WALL,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.places import place_near
from subsea.state.schools import known_by

ASIDE = 1.5  # weight of turning away against keeping the course
MAKING_ROOM = 0.6  # this weight in a school, so that the fish stays with it
SLOWED = 0.35  # share of the fastest speed while a fish ahead passes
CAREFUL = 0.6  # largest share while it rounds an obstacle
PASSING_BL = 0.05  # a fish whose middle is less far aside is straight ahead
AROUND = 0.4  # weight of turning aside from an obstacle against keeping the course
INWARD = 1.5  # likewise from the wall of the sea: so far that large fishes turn sharply
SMALL = 0.2  # a fish yields to none below this share of its length: the small one yields ...
BRUSHED = 0.5  # ... and a hunter in a rush to none below this share
LEVEL_OFF = 0.15  # slope of the way off the seabed and the surface
HEAD_ON = 0.05  # sine of the angle to an obstacle's normal below which both sides are equal
SIDE_PURPOSE = np.int64(167)  # key of the random numbers


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """1 where perception found a danger of collision, else 0.

    Hunters do not yield to prey, nor large fishes to much smaller ones, and in a rush they let
    seabed and surface pass. Prey in panic minds its predator alone: `keep_clear` leads them past
    what they meet. Prey that fears a predator flees it instead. Fishes of a school make room for
    each other by schooling.
    """
    for i in who:
        j = minds.threat[i]
        yields = j != NOBODY and (minds.kind[i] != PREDATOR or minds.kind[j] != PREY)
        small = BRUSHED if minds.hunt[i] == RUSHING else SMALL
        yields = yields and fishes.length[j] > small * fishes.length[i]
        if yields and minds.kind[i] == PREY and minds.kind[j] == PREDATOR:
            yields = minds.mental[i, FEAR] <= nature.alarmed
        if yields and keeps_company(minds, i) and keeps_company(minds, j):
            yields = minds.led[i] or known_by(minds, i) != known_by(minds, j)
        # In cover, contact alone keeps bodies apart.
        yields = yields and not (fishes.close[i] and minds.intention[i] in (BATHE, SHELTER))
        bars = minds.barrier[i] != -1
        if minds.hunt[i] == RUSHING and minds.barrier[i] in (SEABED, SURFACE):
            bars = False  # it slides along
        flees = minds.intention[i] == ESCAPE and minds.mental[i, FEAR] > nature.alarmed
        panics = minds.kind[i] == PREY and (flees or minds.menace[i] >= nature.panicked)
        out[i] = 1.0 if (yields or bars) and not panics else 0.0


@kernel
def keeps_company(minds: Minds, i: int) -> bool:
    """True if fish i schools, or leaves its school to inspect a predator."""
    return minds.intention[i] in (SCHOOL, PICK) or minds.inspection[i] > 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Turn aside; where both sides are equal, to the side that the motor preferences favour.

    From the seabed a fish climbs, and from the surface it dives.
    """
    for i in who:
        ahead = x_axis(fishes.orientation[i])
        j = minds.threat[i]
        if j == NOBODY and minds.barrier[i] == -1:
            continue  # the danger has just passed: it keeps its course
        if j == NOBODY:
            # `steering.keep_clear` leads around obstacles; a slower fish turns more tightly.
            fishes.goal_speed[i] = min(max(fishes.goal_speed[i], SLOWED), CAREFUL)
            set_urge(minds, i, _off_barrier(fishes, minds, i, sea, clock))
            continue
        here = vector(fishes.position[i])
        away = minus(here, place_near(fishes, j, here))
        before = -dot(away, ahead)
        aside = plus(away, times(before, ahead))
        if norm(aside) < PASSING_BL * fishes.length[i]:
            side = _side(minds, i, clock)
            aside = (-side * ahead[1], side * ahead[0], 0.01)
        schooling = minds.memory[i] in (SCHOOL, PICK)
        urge = plus(ahead, times(MAKING_ROOM if schooling else ASIDE, unit(aside)))
        if minds.preference[i, ASCEND] < 0.0 < urge[2]:
            urge = (urge[0], urge[1], 0.0)
        if minds.preference[i, DESCEND] < 0.0 > urge[2]:
            urge = (urge[0], urge[1], 0.0)
        set_urge(minds, i, urge)
        if before > 0.0:
            # In a school, fishes behind it would have to slow down too.
            least = max(0.8 * fishes.goal_speed[j], SLOWED) if schooling else SLOWED
            fishes.goal_speed[i] = min(max(fishes.goal_speed[i], SLOWED), least)


@kernel
def _off_barrier(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> Vector:
    """Urge off the obstacle before fish i.

    Once it turns, it goes on to the same side until the reaction is over: between two stones it
    would waver, and stay.
    """
    ahead, barrier = x_axis(fishes.orientation[i]), minds.barrier[i]
    if barrier in (SEABED, SURFACE):
        slope = LEVEL_OFF if barrier == SEABED else -LEVEL_OFF
        return ahead[0], ahead[1], slope
    eye = plus(vector(fishes.position[i]), times(float(fishes.snout[i]), ahead))
    pillars = len(sea.pillars)
    weight = AROUND
    if barrier == WALL:
        out, weight = unit((-eye[0], -eye[1], 0.0)), INWARD
    elif barrier < pillars:
        out = from_pillar(sea.pillars[barrier], eye)[0]
    else:
        out = from_rock(sea.rocks[barrier - pillars], eye)[0]
    across = ahead[0] * out[1] - ahead[1] * out[0]
    if minds.busy[i] > 0.0:
        turning = ahead[0] * minds.urge[i, 1] - ahead[1] * minds.urge[i, 0]
        across = turning if abs(turning) > HEAD_ON else across
    side = 1.0 if across > 0.0 else -1.0
    if abs(across) < HEAD_ON:
        side = _side(minds, i, clock)
    return ahead[0] - weight * side * ahead[1], ahead[1] + weight * side * ahead[0], ahead[2]


@kernel
def _side(minds: Minds, i: int, clock: Clock) -> float:
    """1 for left, -1 for right: the preferred side, else one at random for each encounter.

    An encounter is a reaction, which began `busy` s ago.
    """
    difference = minds.preference[i, LEFT] - minds.preference[i, RIGHT]
    if difference == 0.0:
        began = clock.tick - np.int64(round(float(minds.busy[i]) / clock.dt))
        return 1.0 if uniform(clock.seed, i, began, SIDE_PURPOSE) < 0.5 else -1.0
    return 1.0 if difference > 0.0 else -1.0
