"""Courtship as a state machine: the action and the end of each state (Tu §7.9.3).

Approaching, looping, circling, spawning ascent, nuzzling (`nuzzling.py`) and the spawning rush
(`spawning.py`). Lengths are in body lengths of the fish; times hold for the recorded size, as
smaller fishes beat and turn faster.
"""

import numpy as np

from subsea.base.arrays import Bools, Ints
from subsea.behavior.chasing import chase, follow, mouth_of, set_urge
from subsea.behavior.manoeuvring import (
    CLOSE_RAD,
    abdomen_of,
    bend,
    careful,
    heading_of,
    hover,
    scull,
    steer,
    tail_of,
    turn_to,
    wrapped,
)
from subsea.behavior.nuzzling import nuzzle, nuzzled
from subsea.behavior.spawning import rush, spawned
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import (
    APPROACHING,
    ASCENDING,
    CIRCLING,
    GUARD,
    LOOPING,
    MATE,
    NO_COURTSHIP,
    NOBODY,
    NUZZLING,
    POSE,
    PREDATOR,
    SPAWNING,
    Clock,
    Fishes,
    Minds,
    Sea,
)

AHEAD_BL, ABOVE_BL = 0.95, 0.25  # his place before her head, in their mean body length
DISPLAY_BL = 1.5  # distance from that place at which he begins
SWING_BL = 0.55  # vertical amplitude of the point that he chases, in his body length
SWING_HZ = 0.2
REACH_BL = 0.45  # distance at which he has reached the point
VIGOUR, BENT = 0.75, 0.25  # share of the fastest speed in a loop; least share of this in turns
POINTS = 3  # reached before he goes on to circle
IMPRESSED = 1  # points a rival reaches before she compares him with her favourite
LARGER = 1.05  # how many times as long a rival must be
BOB_HZ, BOB_SLOPE = 0.45, 0.5  # nods of her head while she looks on
CIRCLING_BL, CIRCLING_SPEED = 0.45, 0.2  # distance to the other's tail; share of the fastest
CLOSE_BL, CLOSING_BL_S = 0.8, 0.3  # distance of their middles to which fins draw them; how fast
ROOM_BL = 0.7  # distance of their middles below which he passes above her
ASTRAY_RAD, LEAST_RAD = np.radians((60.0, 15.0))  # angle beyond which he circles on; least turn
TURNS = 2.0  # that she makes before they ascend
RISE_BL = 2.5  # height of her ascent, in her body lengths ...
CEILING_BL, CEILING_CM = 1.6, 10.0  # ... but no nearer to the surface
RISING, LEAST_RISE = 0.7, 0.08  # share of the fastest speed of her ascent; while he is behind
WAITS_BL = 0.7  # distance of their middles from which she waits for him
STEEP = 0.78  # slope of her ascent: the motor system's steepest
FOLLOWED_BL = 0.8  # distance from her abdomen at which he has kept up
BELOW_BL, BEHIND_BL = 0.12, 0.25  # how far under and behind her abdomen he keeps his mouth
BESIDE_BL = 0.6  # distance of his mouth from that place at which he heads as she does
KEEP_S = 0.4  # time in which he closes a gap by swimming
KEEPING_BL_S = 0.6  # how fast his fins keep him there

# For each state, from none to spawning: time after which it is given up, ...
LIMIT_S = np.array([np.inf, 60.0, 45.0, 30.0, 20.0, 30.0, 60.0])
# ... and how long the partner may attend to something else.
ALONE_S = np.array([np.inf, 25.0, 8.0, 8.0, 8.0, 8.0, 8.0])
COLOUR_S = 0.7  # time constant of mating colours: 95% of a change is done after 2 s


@kernel
def approach(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Chase her; if she intends to mate, the place before her head where he displays."""
    for i in who:
        j = np.int64(minds.partner[i])
        if minds.intention[j] == MATE:
            chase(fishes, minds, i, stage(fishes, i, j), vector(fishes.velocity[j]))
            continue
        follow(fishes, minds, i, j)


@kernel
def arrived(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """True if he is where he can display, and she intends to mate."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        i = who[k]
        j = np.int64(minds.partner[i])
        distance = norm(minus(stage(fishes, i, j), mouth_of(fishes, i)))
        near = distance < DISPLAY_BL * 0.5 * (fishes.length[i] + fishes.length[j])
        done[k] = near and minds.intention[j] == MATE
    return done


@kernel
def loop(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """He chases a point that moves up and down before her head; she hovers and bobs her head."""
    for i in who:
        if not minds.male[i]:
            hover(fishes, minds, i, BOB_SLOPE * np.sin(_beat(fishes, i, BOB_HZ, clock)))
            continue
        j = np.int64(minds.partner[i])
        swing = _beat(fishes, i, SWING_HZ, clock) + 2.0 * np.pi * fishes.identity[i]
        height = SWING_BL * fishes.length[i] * np.sin(swing)
        point = plus(stage(fishes, i, j), (0.0, 0.0, height))
        toward = minus(point, mouth_of(fishes, i))
        turn = steer(fishes, minds, i, toward)
        fishes.goal_speed[i] = VIGOUR * max(np.cos(turn), BENT)
        minds.courtship_mark[i] -= minds.pause[i] * fishes.size_rate[i]
        reached = norm(toward) < REACH_BL * fishes.length[i]
        if reached and minds.courtship_mark[i] <= 0.0:
            # It counts again once the point is at its other end.
            minds.courtship_mark[i] = 0.4 / SWING_HZ
            minds.courtship_count[i] += 1.0
            minds.fatigue[MATE, i] = 0.0
        _impress(fishes, minds, i, j)


@kernel
def _impress(fishes: Fishes, minds: Minds, i: int, j: int) -> None:
    """Make male i the favourite of female j if she prefers him to the present one."""
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
    """True if female j prefers male i: her own species first, then size (Tu §7.9.3)."""
    own, other = fishes.species[i] == fishes.species[j], fishes.species[best] == fishes.species[j]
    if own != other:
        return bool(own)
    return bool(fishes.length[i] > LARGER * fishes.length[best])


@kernel
def chosen(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """True if he has reached the point often enough and is her favourite."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        i = who[k]
        favoured = minds.partner[minds.partner[i]] == i
        done[k] = minds.male[i] and favoured and minds.courtship_count[i] >= POINTS
    return done


@kernel
def circle(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Each chases the other's tail in the same sense; her turns are counted."""
    for i in who:
        j = np.int64(minds.partner[i])
        male = i if minds.male[i] else j
        way = 1.0 if fishes.identity[male] < 0.5 else -1.0
        toward = plus(
            minus(tail_of(fishes, j), mouth_of(fishes, i)), _make_room(fishes, i, j, minds.male[i])
        )
        turn = way * turn_to(fishes, i, toward)
        # They go on round to a tail that is behind, or one of them would swim away.
        if turn < -ASTRAY_RAD:
            turn += 2.0 * np.pi
        bend(fishes, minds, i, toward, way * min(max(turn, LEAST_RAD), CLOSE_RAD))
        gap = norm(toward) / (CIRCLING_BL * fishes.length[i])
        fishes.goal_speed[i] = CIRCLING_SPEED * min(max(gap, 0.3), 3.0) * max(np.cos(turn), 0.3)
        apart = minus(vector(fishes.position[j]), vector(fishes.position[i]))
        room = CLOSE_BL * 0.5 * (fishes.length[i] + fishes.length[j])
        beyond = max(1.0 - room / max(norm(apart), 1e-6), 0.0)
        scull(fishes, i, times(0.5 * beyond, apart), CLOSING_BL_S)
        heading = heading_of(fishes, i)
        gained = wrapped(heading - minds.courtship_mark[i])
        minds.courtship_mark[i] = heading
        minds.courtship_count[i] += gained / (2.0 * np.pi)


@kernel
def _make_room(fishes: Fishes, i: int, j: int, upward: bool) -> Vector:
    """Vertical offset, cm, by which one passes above the other while they are too near."""
    gap = norm(minus(vector(fishes.position[i]), vector(fishes.position[j])))
    room = max(ROOM_BL * 0.5 * (fishes.length[i] + fishes.length[j]) - gap, 0.0)
    return 0.0, 0.0, room if upward else -room


@kernel
def circled(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """True if she has turned often enough."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        done[k] = not minds.male[who[k]] and abs(minds.courtship_count[who[k]]) >= TURNS
    return done


@kernel
def ascend(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """She ascends fast, then hovers; he keeps close behind her abdomen."""
    for i in who:
        if minds.male[i]:
            _keep_up(fishes, minds, i, np.int64(minds.partner[i]))
        elif _at_top(fishes, minds, i):
            hover(fishes, minds, i, 0.0)
        else:
            ahead = x_axis(fishes.orientation[i])
            level = max(np.sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1]), 1e-6)
            set_urge(minds, i, (ahead[0], ahead[1], STEEP * level))
            gap = norm(minus(vector(fishes.position[minds.partner[i]]), vector(fishes.position[i])))
            behind = max(gap / fishes.length[i] - WAITS_BL, 0.0)
            fishes.goal_speed[i] = max(RISING - behind, LEAST_RISE)


@kernel
def _keep_up(fishes: Fishes, minds: Minds, i: int, j: int) -> None:
    """Follow the abdomen of fish j closely: near it, on a course beside hers."""
    length = float(fishes.length[i])
    x = x_axis(fishes.orientation[j])
    behind = plus(abdomen_of(fishes, j), times(-BEHIND_BL * length, x))
    toward = minus(plus(behind, (0.0, 0.0, -BELOW_BL * length)), mouth_of(fishes, i))
    distance = norm(toward)
    scull(fishes, i, toward, KEEPING_BL_S)
    if distance > BESIDE_BL * length:
        share = min(distance / length, 1.0)
        fishes.goal_speed[i] = share * careful(steer(fishes, minds, i, toward))
        return
    steer(fishes, minds, i, plus(x, times(1.0 / length, toward)))
    own = norm(vector(fishes.velocity[j])) + dot(toward, x) / KEEP_S
    fishes.goal_speed[i] = min(max(own / float(fishes.fast[i]), 0.0), 1.0)


@kernel
def ascended(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """True if she hovers at the peak of her ascent and he is there."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        i = who[k]
        if minds.male[i] or not _at_top(fishes, minds, i):
            continue
        j = np.int64(minds.partner[i])
        distance = norm(minus(abdomen_of(fishes, i), mouth_of(fishes, j)))
        done[k] = distance < FOLLOWED_BL * fishes.length[j]
    return done


@kernel
def _at_top(fishes: Fishes, minds: Minds, i: int) -> bool:
    """True if she has risen by RISE_BL, or to the ceiling below the surface."""
    height = fishes.position[i, 2]
    ceiling = -CEILING_BL * fishes.length[i] - CEILING_CM
    return bool(height > min(minds.courtship_mark[i] + RISE_BL * fishes.length[i], ceiling))


@kernel
def enter(fishes: Fishes, minds: Minds, i: int, code: int) -> None:
    """Begin a state with fresh counters."""
    minds.courtship[i] = code
    minds.courtship_time[i] = 0.0
    minds.courtship_count[i] = 0.0
    minds.courtship_mark[i] = 0.0
    if code == CIRCLING:
        minds.courtship_mark[i] = heading_of(fishes, i)
    elif code in (ASCENDING, SPAWNING):
        minds.courtship_mark[i] = fishes.position[i, 2]
    minds.alone[i] = 0.0
    minds.fatigue[MATE, i] = 0.0


@kernel
def stage(fishes: Fishes, i: int, j: int) -> Vector:
    """The place before and slightly above the head of fish j where fish i displays."""
    x = x_axis(fishes.orientation[j])
    level = max(np.sqrt(x[0] * x[0] + x[1] * x[1]), 1e-6)
    length = 0.5 * (fishes.length[i] + fishes.length[j])
    ahead = fishes.snout[j] + AHEAD_BL * length
    offset = (ahead * x[0] / level, ahead * x[1] / level, ABOVE_BL * length)
    return plus(vector(fishes.position[j]), offset)


@kernel
def _beat(fishes: Fishes, i: int, hertz: float, clock: Clock) -> float:
    """Phase of an oscillation with this frequency at the recorded size."""
    return 2.0 * np.pi * hertz * fishes.size_rate[i] * clock.tick * clock.dt


@kernel
def perform(state: int, who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> Bools:
    """Perform a state for each of the fishes `who`; return which of them completed it."""
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
    if state == NUZZLING:
        nuzzle(who, fishes, minds, sea, clock)
        return nuzzled(who, fishes, minds, sea)
    rush(who, fishes, minds, sea, clock)
    return spawned(who, fishes, minds, sea)


@kernel
def ease_display(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Ease the display of the fishes `who` to 1 where a male courts, else to 0 (Tu §5.3).

    By night it eases to -1: fishes that are awake by day turn pale, but not their predators. A
    fish raises its fins to a mate and to a predator in sight.
    """
    share = 1.0 - np.exp(-clock.dt / COLOUR_S)
    pale = 1.0 - sea.sky[1]
    for i in who:
        courts = fishes.alive[i] and minds.male[i] and minds.courtship[i] != NO_COURTSHIP
        calm = 0.0 if minds.kind[i] == PREDATOR else -pale
        fishes.display[i] += share * ((1.0 if courts else calm) - fishes.display[i])
        shows = minds.intention[i] == GUARD or minds.intention[i] == POSE
        threat = 1.0 if shows else float(minds.menace[i])
        fishes.raised[i] = max(float(fishes.display[i]), threat, 0.0)
