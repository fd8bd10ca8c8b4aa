"""Courtship as a state machine: what each state does and when it is completed (Tu §7.9.3).

Approaching, looping, circling, spawning ascent, nuzzling. Lengths are in body lengths of the
fish, times in those of the recorded fish: a smaller one beats and turns faster.
"""

import numpy as np

from subsea.behavior.chasing import chase, follow, mouth_of, set_urge
from subsea.behavior.manoeuvring import (
    CLOSE_RAD,
    abdomen_of,
    bend,
    careful,
    heading_of,
    hover,
    steer,
    tail_of,
    turn_to,
    wrapped,
)
from subsea.behavior.nuzzling import nuzzle, nuzzled
from subsea.core.arrays import Bools, Ints
from subsea.core.kernels import kernel
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, minus, norm, plus, vector
from subsea.state import (
    APPROACHING,
    ASCENDING,
    CIRCLING,
    LOOPING,
    MATE,
    NOBODY,
    Clock,
    Fishes,
    Minds,
    Sea,
)

AHEAD_BL, ABOVE_BL = 1.15, 0.25  # where before her head he shows off, in their mean body length
DISPLAY_BL = 1.5  # so near that place he begins to
SWING_BL = 0.55  # how far up and down the point moves that he chases, in his
SWING_HZ = 0.14
REACH_BL = 0.45  # so near the point he has reached it
VIGOUR, BENT = 0.75, 0.25  # share of the fastest speed at which he loops, and of that in turns
POINTS = 4  # reached, and he goes on to circle
IMPRESSED = 1  # point reached by a rival before she compares him with the one she favours
LARGER = 1.05  # times as long a rival must be
BOB_HZ, BOB_SLOPE = 0.45, 0.5  # of her head while she looks on
CIRCLING_BL, CIRCLING_SPEED = 0.45, 0.2  # distance to the other's tail, at which speed
ROOM_BL = 0.8  # middles nearer than that: he passes above her
ASTRAY_RAD, LEAST_RAD = np.radians((60.0, 15.0))  # a tail farther astray; the least turn
TURNS = 2.0  # of hers, and they go on to the ascent
RISE_BL = 4.0  # how far she ascends, in her body lengths ...
CEILING_BL, CEILING_CM = 1.6, 10.0  # ... but no nearer to the surface
LEAST_RISE = 0.4  # share of the fastest speed at which she ascends while he is left behind
STEEP = 0.78  # slope of her ascent: the motor system's steepest
FOLLOWED_BL = 1.3  # so near her abdomen he has kept up
BELOW_BL = 0.3  # and so far under it he keeps, in his

# For each state, none to nuzzling: it is given up after so long, ...
LIMIT_S = np.array([np.inf, 60.0, 60.0, 45.0, 30.0, 60.0])
# ... or when the partner has minded somebody or something else for so long.
ALONE_S = np.array([np.inf, 25.0, 8.0, 10.0, 10.0, 10.0])


@kernel
def approach(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Chase her, or the place before her head where he will show off if she has a mind to mate."""
    for i in who:
        j = minds.partner[i]
        if minds.intention[j] == MATE:
            chase(fishes, minds, i, stage(fishes, i, j), vector(fishes.velocity[j]))
            continue
        follow(fishes, minds, i, j)


@kernel
def arrived(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """He is where he can show off, and she has a mind to look."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        i = who[k]
        j = minds.partner[i]
        distance = norm(minus(stage(fishes, i, j), mouth_of(fishes, i)))
        near = distance < DISPLAY_BL * 0.5 * (fishes.length[i] + fishes.length[j])
        done[k] = near and minds.intention[j] == MATE
    return done


@kernel
def loop(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """He chases a point before her head that moves up and down; she hovers and bobs her head."""
    for i in who:
        if not minds.male[i]:
            hover(fishes, minds, i, BOB_SLOPE * np.sin(_beat(fishes, i, BOB_HZ, clock)))
            continue
        j = minds.partner[i]
        swing = _beat(fishes, i, SWING_HZ, clock) + 2.0 * np.pi * fishes.identity[i]
        height = SWING_BL * fishes.length[i] * np.sin(swing)
        point = plus(stage(fishes, i, j), (0.0, 0.0, height))
        toward = minus(point, mouth_of(fishes, i))
        turn = steer(fishes, minds, i, toward)
        fishes.goal_speed[i] = VIGOUR * max(np.cos(turn), BENT)
        minds.courtship_mark[i] -= minds.pause[i] * fishes.rate[i]
        reached = norm(toward) < REACH_BL * fishes.length[i]
        if reached and minds.courtship_mark[i] <= 0.0:
            # The point must be at its other end before it counts again.
            minds.courtship_mark[i] = 0.4 / SWING_HZ
            minds.courtship_count[i] += 1.0
            minds.fatigue[MATE, i] = 0.0
        _impress(fishes, minds, i, j)


@kernel
def _impress(fishes: Fishes, minds: Minds, i: int, j: int) -> None:
    """Let her favour the male that loops before her if he is better than whom she favours."""
    best = minds.partner[j]
    if best == i or minds.intention[j] != MATE or minds.courtship[j] > LOOPING:
        return
    impressive = minds.courtship_count[i] >= IMPRESSED
    if best != NOBODY and not (impressive and preferred(fishes, j, i, best)):
        return
    enter(fishes, minds, j, LOOPING)
    minds.partner[j] = i


@kernel
def preferred(fishes: Fishes, j: int, i: int, best: int) -> bool:
    """Whether female j prefers male i: her own species first, then size (Tu §7.9.3)."""
    own, other = fishes.species[i] == fishes.species[j], fishes.species[best] == fishes.species[j]
    if own != other:
        return bool(own)
    return bool(fishes.length[i] > LARGER * fishes.length[best])


@kernel
def chosen(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """He has reached the point often enough, and it is him that she favours."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        i = who[k]
        favoured = minds.partner[minds.partner[i]] == i
        done[k] = minds.male[i] and favoured and minds.courtship_count[i] >= POINTS
    return done


@kernel
def circle(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Each chases the other's tail, both the same way round; her turns are counted."""
    for i in who:
        j = minds.partner[i]
        male = i if minds.male[i] else j
        way = 1.0 if fishes.identity[male] < 0.5 else -1.0
        toward = plus(
            minus(tail_of(fishes, j), mouth_of(fishes, i)), _make_room(fishes, i, j, minds.male[i])
        )
        turn = way * turn_to(fishes, i, toward)
        # A tail that is behind is reached by going on round, or one of them would run away.
        if turn < -ASTRAY_RAD:
            turn += 2.0 * np.pi
        bend(fishes, minds, i, toward, way * min(max(turn, LEAST_RAD), CLOSE_RAD))
        gap = norm(toward) / (CIRCLING_BL * fishes.length[i])
        fishes.goal_speed[i] = CIRCLING_SPEED * min(max(gap, 0.3), 3.0) * max(np.cos(turn), 0.3)
        heading = heading_of(fishes, i)
        gained = wrapped(heading - minds.courtship_mark[i])
        minds.courtship_mark[i] = heading
        minds.courtship_count[i] += gained / (2.0 * np.pi)


@kernel
def _make_room(fishes: Fishes, i: int, j: int, upward: bool) -> Vector:
    """How far, cm, one of two passes above the other while their middles are too near."""
    gap = norm(minus(vector(fishes.position[i]), vector(fishes.position[j])))
    room = max(ROOM_BL * 0.5 * (fishes.length[i] + fishes.length[j]) - gap, 0.0)
    return 0.0, 0.0, room if upward else -room


@kernel
def circled(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """She has turned round often enough."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        done[k] = not minds.male[who[k]] and abs(minds.courtship_count[who[k]]) >= TURNS
    return done


@kernel
def ascend(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """She ascends fast, then hovers; he follows her abdomen."""
    for i in who:
        if minds.male[i]:
            j = minds.partner[i]
            under = minus(abdomen_of(fishes, j), (0.0, 0.0, BELOW_BL * fishes.length[i]))
            toward = minus(under, mouth_of(fishes, i))
            speed = min(norm(toward) / fishes.length[i], 1.0)
            fishes.goal_speed[i] = speed * careful(steer(fishes, minds, i, toward))
        elif _at_top(fishes, minds, i):
            hover(fishes, minds, i, 0.0)
        else:
            ahead = x_axis(fishes.orientation[i])
            level = max(np.sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1]), 1e-6)
            set_urge(minds, i, (ahead[0], ahead[1], STEEP * level))
            gap = norm(minus(vector(fishes.position[minds.partner[i]]), vector(fishes.position[i])))
            fishes.goal_speed[i] = min(max(2.0 - 0.5 * gap / fishes.length[i], LEAST_RISE), 1.0)


@kernel
def ascended(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """She hovers at the peak of her ascent, and he is there."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        i = who[k]
        if minds.male[i] or not _at_top(fishes, minds, i):
            continue
        j = minds.partner[i]
        distance = norm(minus(abdomen_of(fishes, i), mouth_of(fishes, j)))
        done[k] = distance < FOLLOWED_BL * fishes.length[j]
    return done


@kernel
def _at_top(fishes: Fishes, minds: Minds, i: int) -> bool:
    """Whether she has risen as far as she wants, or as the surface lets her."""
    height = fishes.position[i, 2]
    ceiling = -CEILING_BL * fishes.length[i] - CEILING_CM
    return bool(height > min(minds.courtship_mark[i] + RISE_BL * fishes.length[i], ceiling))


@kernel
def enter(fishes: Fishes, minds: Minds, i: int, code: int) -> None:
    """Begin a state: nothing counted yet."""
    minds.courtship[i] = code
    minds.courtship_time[i] = 0.0
    minds.courtship_count[i] = 0.0
    minds.courtship_mark[i] = 0.0
    if code == CIRCLING:
        minds.courtship_mark[i] = heading_of(fishes, i)
    elif code == ASCENDING:
        minds.courtship_mark[i] = fishes.position[i, 2]
    minds.alone[i] = 0.0
    minds.fatigue[MATE, i] = 0.0


@kernel
def stage(fishes: Fishes, i: int, j: int) -> Vector:
    """The place in front of and slightly above the head of fish j where fish i shows off."""
    x = x_axis(fishes.orientation[j])
    level = max(np.sqrt(x[0] * x[0] + x[1] * x[1]), 1e-6)
    length = 0.5 * (fishes.length[i] + fishes.length[j])
    ahead = fishes.snout[j] + AHEAD_BL * length
    offset = (ahead * x[0] / level, ahead * x[1] / level, ABOVE_BL * length)
    return plus(vector(fishes.position[j]), offset)


@kernel
def _beat(fishes: Fishes, i: int, hertz: float, clock: Clock) -> float:
    """Phase of an oscillation that has this frequency in a fish of recorded size."""
    return 2.0 * np.pi * hertz * fishes.rate[i] * clock.tick * clock.dt


@kernel
def perform(state: int, who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> Bools:
    """Do what a state asks of each of the fishes `who`; return which of them completed it."""
    if state == APPROACHING:
        approach(who, fishes, minds, sea, clock)
        return arrived(who, fishes, minds, sea)
    if state == LOOPING:
        loop(who, fishes, minds, sea, clock)
        return chosen(who, fishes, minds, sea)
    if state == CIRCLING:
        circle(who, fishes, minds, sea, clock)
        return circled(who, fishes, minds, sea)
    if state == ASCENDING:
        ascend(who, fishes, minds, sea, clock)
        return ascended(who, fishes, minds, sea)
    nuzzle(who, fishes, minds, sea, clock)
    return nuzzled(who, fishes, minds, sea)
