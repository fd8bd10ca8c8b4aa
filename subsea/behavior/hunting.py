"""Hunting: stalk prey, rush at it, open the mouth and suck it in (Tu §7.8.2, §7.9.1).

A hunt has phases (`state.HUNT`). On patrol a predator swims calmly until it is hungry and its lull
is over. It stalks a prey low, from below or behind, and rushes once it is near: a burst of under
two seconds at one prey, with a snap of the head. After a catch it chews. After a miss it breaks
off, circles out and rests (Hobson, *Feeding behavior in three species of sharks*, 1963).
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import burst, chase, mouth_of, set_urge
from subsea.behavior.death import remove
from subsea.behavior.manoeuvring import turn_to, wrapped
from subsea.behavior.patrolling import give_way, is_blocked
from subsea.behavior.wandering import wander
from subsea.geometry.noise import uniform
from subsea.geometry.periodic import nearest_image
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import height_at
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, store, times, unit, vector
from subsea.kernels import kernel
from subsea.state import (
    CHEWING,
    EAT,
    ESCAPE,
    HUNGER,
    NOBODY,
    PATROLLING,
    PREDATOR,
    PREY,
    RECOVERING,
    RUSHING,
    STALKING,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.places import place_near

STILL_HUNGRY = 0.6  # share of `keen` below which a hunter stops
EAGER = 1.5  # least desire of a hunter over `keen`, so that it does not waver

STALK, PURSUIT = 0.7, 1.0  # shares of the fastest speed: toward calm prey, and prey that flees
AMBUSH_BL = 0.9, 0.5  # place to which it stalks: behind the prey and below it
ROUND_RAD = np.radians(50.0)  # part of a circle about the prey by which it aims ahead ...
ROUND = 0.8  # ... at this share of the distance, until it is in the blind angle
GENTLE = 1.8  # distance of that place over its depth or height, as hunters climb slowly
BOTTOM_BL = 0.3  # least height of that place over the seabed
STALK_S = 14.0  # longest stalk ...
CHASE_S = 6.0  # ... of prey that flees far off ...
ALMOST_S = 4.0  # ... and how much longer it is at prey within range of a rush, if this flees or not
LOST_S = 4.0  # rest after it lost its prey, so that it does not waver
PATIENT_S = 6.0  # after which it hides no longer, and rushes from any side
REAR_COS = -0.5  # cosine of its bearing from the prey's heading at which it closes in ...
BLIND_COS = np.cos(np.radians(150.0))  # ... and in the blind angle (Tu §6.3)
LOW = 0.3  # slope up to the prey from which it is hidden below

RUSH_BL = 2.0  # distance within which it rushes from there ...
CHASE_BL = 2.2  # ... or at prey that flees ...
AIM_RAD = np.radians(30.0)  # ... if it heads for it, or can snap at it ...
STEEPEST = 0.5  # ... and no steeper up or down, as it could not follow
READY_S = 1.0  # spent part of a burst below which it rushes
RUSH_S = 1.8  # longest rush
MISSED_RAD = np.radians(75.0)  # angle to the prey beyond which a rush has missed
SNAP_BL = 0.9  # distance within which it snaps its head round to the prey ...
SNAP_RAD = np.radians(25.0), np.radians(65.0)  # ... that is so far aside ...
SNAPPED_S = 2.0  # ... once in a rush
LEAD = 0.7  # share of its burst's speed by which it foresees where they meet

RECOVER_S = 4.5  # circling out after a miss
LULL_S = np.array([[4.0, 10.0], [12.0, 22.0]])  # until the next stalk: after a miss, after a meal
CALM = 2.0  # by how much longer a lull is without hunger
LULL_PURPOSE = np.int64(164)  # key of the random numbers

ATTENTION_TICKS = 20  # until its attention may pass to another fish of a crowd, 0.67 s
CROWD_BL = 5.0  # distance, in lengths of the prey, within which fishes confuse the hunter ...
CONFUSION = 0.4  # ... by this power of their number
ATTENTION_PURPOSE = np.int64(82)  # key of the random numbers
CHEW_S = 5.0  # chewing the catch: time for the others to scatter
CHEWS_PER_S = 2.5

FITS = 0.45  # longest prey that it can swallow, over its own length
OPEN_BL = 0.35  # distance to the prey below which a hunter opens its mouth
OPEN = 0.5  # gape above which a mouth draws water in
SUCK_BL = 0.3  # reach of the suction ...
SUCK_BL_S = 2.0  # ... and its speed at the mouth
# Prey is in the mouth when its middle is within these shares of the hunter's and its own length.
MOUTH_BL, MIDDLE = 0.08, 0.2


@kernel
def advance_hunts(who: Ints, fishes: Fishes, minds: Minds, clock: Clock) -> None:
    """Let time pass in the hunts of the predators among the fishes `who`, and end what is over."""
    for i in who:
        if minds.kind[i] != PREDATOR:
            continue
        minds.hunt_time[i] += minds.pause[i]
        minds.lull[i] = max(minds.lull[i] - minds.pause[i], np.float32(0.0))
        phase, spell = minds.hunt[i], minds.hunt_time[i]
        eats = minds.intention[i] == EAT or minds.memory[i] == EAT
        if phase == RUSHING and (spell > RUSH_S or not eats):
            break_off(minds, i, clock)
            continue
        lost = phase == STALKING and not eats
        if lost:
            minds.lull[i] = max(minds.lull[i], np.float32(LOST_S))
        over = lost or (phase == CHEWING and spell > CHEW_S)
        if over or (phase == RECOVERING and spell > RECOVER_S):
            begin(minds, i, PATROLLING)


@kernel
def begin(minds: Minds, i: int, phase: int) -> None:
    """Begin a phase of the hunt of fish i."""
    minds.hunt[i] = phase
    minds.hunt_time[i] = 0.0


@kernel
def break_off(minds: Minds, i: int, clock: Clock) -> None:
    """End a rush of fish i that missed: circle out, and rest the less the oftener it missed."""
    begin(minds, i, RECOVERING)
    minds.misses[i] += 1.0
    minds.lull[i] = RECOVER_S + _lull(minds, i, 0, clock) / (0.5 + 0.5 * float(minds.misses[i]))
    minds.missed[i] = minds.target[i]
    minds.target[i] = -1


@kernel
def _lull(minds: Minds, i: int, fed: int, clock: Clock) -> float:
    """Draw the time, s, until fish i stalks again; the less hungry, the longer."""
    low, high = LULL_S[fed]
    share = uniform(clock.seed, i, clock.tick, LULL_PURPOSE)
    return (low + (high - low) * share) * (1.0 + CALM * (1.0 - float(minds.mental[i, HUNGER])))


@kernel
def hunger(minds: Minds, i: int, nature: Nature) -> float:
    """The desire of a predator to hunt: its hunger, unless it rests between two hunts."""
    phase = minds.hunt[i]
    if phase == CHEWING:
        return EAGER * nature.keen
    hunts = phase in (STALKING, RUSHING)
    least = nature.keen * (STILL_HUNGRY if hunts else 1.0)
    if minds.food[i] < 0 or rests(minds, i) or minds.mental[i, HUNGER] <= least:
        return 0.0
    return max(minds.mental[i, HUNGER], EAGER * nature.keen if hunts else 0.0)


@kernel
def rests(minds: Minds, i: int) -> bool:
    """True if hunter i rests between two hunts."""
    phase = minds.hunt[i]
    return phase == RECOVERING or (phase == PATROLLING and minds.lull[i] > 0.0)


@kernel
def hunt(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> None:
    """Stalk the prey, rush at it once near, and open the mouth at it.

    Without prey, or while it chews the last one or rests, cruise.
    """
    # The intention generator has added a second per second: a hunter rests by its lulls instead.
    minds.fatigue[EAT, i] = max(minds.fatigue[EAT, i] - minds.pause[i], np.float32(0.0))
    j = minds.target[i] if minds.target[i] >= 0 else minds.food[i]
    chews = minds.hunt[i] == CHEWING
    if j < 0 or not fishes.alive[j] or chews or rests(minds, i):
        wander(fishes, minds, i, sea, clock)
        if chews:
            part = np.sin(2.0 * np.pi * CHEWS_PER_S * float(minds.hunt_time[i]))
            fishes.gape[i] = 0.15 + 0.15 * part
        elif minds.hunt[i] == RUSHING:
            break_off(minds, i, clock)
        return
    minds.target[i] = j
    if minds.hunt[i] != RUSHING:
        if minds.hunt[i] != STALKING:
            begin(minds, i, STALKING)
        _stalk(fishes, minds, i, sea, clock)
    if minds.hunt[i] == RUSHING:
        _rush(fishes, minds, i, clock)


@kernel
def _stalk(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> None:
    """Swim to a place below and behind the prey; begin the rush, or give up after a while.

    It rounds the prey until it is in the blind angle, then closes in. From prey that flees, and
    after a while, it hides no longer, but closes the gap. Prey that it gives up costs it more for a
    while, so that it turns to another.
    """
    j, length = np.int64(minds.target[i]), float(fishes.length[i])
    mouth = mouth_of(fishes, i)
    prey = place_near(fishes, j, mouth)
    toward, heading = minus(prey, mouth), x_axis(fishes.orientation[j])
    distance = max(norm(toward), 1e-6)
    back, down = AMBUSH_BL
    back = max(back * length, GENTLE * abs(toward[2]))
    fled, spell = minds.intention[j] == ESCAPE, minds.hunt_time[i]
    hides = not fled and spell <= PATIENT_S
    rear = -dot(toward, heading) / distance
    bearing, tail = np.arctan2(-toward[1], -toward[0]), np.arctan2(-heading[1], -heading[0])
    turn = wrapped(tail - bearing)
    if rear > REAR_COS and hides:
        back = max(back, ROUND * distance)
    bearing += min(max(turn, -ROUND_RAD), ROUND_RAD)
    place = plus(prey, times(back, (np.cos(bearing), np.sin(bearing), 0.0)))
    floor = height_at(sea.floor, sea.half_width, place[0], place[1]) + BOTTOM_BL * length
    place = (place[0], place[1], max(place[2] - down * length, min(floor, prey[2])))
    chase(fishes, minds, i, place, vector(fishes.velocity[j]))
    set_urge(minds, i, give_way(fishes, minds, i, vector(minds.urge[i])))
    fishes.goal_speed[i] = STALK if hides else PURSUIT
    good = not hides or toward[2] > LOW * distance or rear <= BLIND_COS
    near = good and distance < (CHASE_BL if fled else RUSH_BL) * length
    near = near and abs(toward[2]) < STEEPEST * distance
    aside = SNAP_RAD[1] if distance < SNAP_BL * length else AIM_RAD
    aim = dot(toward, x_axis(fishes.orientation[i])) > np.cos(aside) * distance
    if near and not aim:
        set_urge(minds, i, give_way(fishes, minds, i, toward))
    if near and aim and minds.spent[i] < READY_S and not is_blocked(fishes, minds, i):
        begin(minds, i, RUSHING)
    elif spell > (STALK_S + ALMOST_S if near else CHASE_S if fled else STALK_S):
        begin(minds, i, PATROLLING)
        minds.lull[i], minds.missed[i] = LOST_S, j


@kernel
def _rush(fishes: Fishes, minds: Minds, i: int, clock: Clock) -> None:
    """Burst at the prey, or at another that attention passes to; snap at it, or break off.

    The snap is a C-start to its side, whose first stage bends the body within 0.1 s.
    """
    j, length = np.int64(minds.target[i]), float(fishes.length[i])
    j, sure = attended(fishes, minds, i, j, clock)
    minds.target[i] = j
    mouth = mouth_of(fishes, i)
    toward = minus(place_near(fishes, j, mouth), mouth)
    gap = norm(toward)
    speed = max(LEAD * fishes.burst[i] * fishes.fast[i], 1.0)
    drift = minus(vector(fishes.velocity[j]), vector(fishes.drift[i]))
    way = unit(plus(toward, times(gap / speed, drift)))
    set_urge(minds, i, way)
    store(fishes.goal_direction[i], way)  # at once: its aim does not lag
    burst(fishes, minds, i)
    ahead = dot(toward, x_axis(fishes.orientation[i]))
    aside = turn_to(fishes, i, toward)
    low, high = SNAP_RAD
    if gap < SNAP_BL * length and low < abs(aside) < high and minds.startled[i] > SNAPPED_S:
        fishes.startle[i], minds.startled[i] = aside, 0.0
    fishes.gape[i] = 1.0 if gap < OPEN_BL * length and sure else 0.0
    missed = ahead < np.cos(MISSED_RAD) * gap and gap > OPEN_BL * length
    if missed or is_blocked(fishes, minds, i):
        break_off(minds, i, clock)


@kernel
def companions(fishes: Fishes, minds: Minds, j: int) -> int:
    """Count the prey that are near enough to fish j to confuse its hunter."""
    here, reach = vector(fishes.position[j]), CROWD_BL * float(fishes.length[j])
    count = 0
    for k in range(len(fishes.length)):
        there = place_near(fishes, k, here)
        if abs(there[0] - here[0]) > reach or k == j or minds.kind[k] != PREY:
            continue
        gap = minus(there, here)
        count += fishes.alive[k] and dot(gap, gap) < reach * reach
    return count


@kernel
def attended(fishes: Fishes, minds: Minds, i: int, j: int, clock: Clock) -> tuple[int, bool]:
    """Return the fish that hunter i attends to, and whether it is sure of it.

    Prey that cross its view draw its attention from prey j. For a spell of ATTENTION_TICKS it stays
    with j in one case of (1 + companions) ** CONFUSION; else it turns to a neighbour of j, which
    costs it the spell: it opens its mouth only if it is sure. So the risk of each attack falls with
    the size of the group (Neill and Cullen, J. Zool. 172:549, 1974).
    """
    spell = clock.tick // ATTENTION_TICKS
    before = clock.tick - round(minds.pause[i] / clock.dt)  # its last decision
    drawn = uniform(clock.seed, i, spell, ATTENTION_PURPOSE)
    stays = (1.0 + companions(fishes, minds, j)) ** -CONFUSION
    if drawn < stays or before // ATTENTION_TICKS == spell:
        return j, drawn < stays
    nearest = minds.neighbour[j]
    k = int(nearest[int((drawn - stays) / (1.0 - stays) * len(nearest))])
    first, end, kind = minds.quarry[i]
    quarry = first <= k < end and (kind < 0 or fishes.species[k] == kind)
    quarry = quarry and k != minds.conceded[i]
    return (k if quarry and fishes.alive[k] and minds.kind[k] == PREY else j), False


@kernel
def inhale(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Draw fishes and plankton toward open mouths, and eat prey inside; runs every tick.

    Fishes are moved by their `drift`, specks directly. The mouths are few and sorted along x, so
    that no pass goes over all pairs, except in a box, where mouths are also beyond its sides.
    """
    in_box = fishes.period[0] > 0.0
    mouths, x = _open_mouths(fishes, minds)
    if len(mouths) == 0:
        return
    longest = 0.0
    for i in mouths:
        longest = max(longest, fishes.length[i])
    farthest = SUCK_BL * longest
    for j in range(len(fishes.species)):
        if not fishes.alive[j]:
            continue
        there = vector(fishes.position[j])
        first = 0 if in_box else np.searchsorted(x, there[0] - farthest)
        for k in range(first, len(mouths)):
            i = mouths[k]
            if (x[k] > there[0] + farthest and not in_box) or not fishes.alive[j]:
                break
            if i == j or fishes.gape[i] <= OPEN:  # shut on another since
                continue
            mouth = nearest_image(mouth_of(fishes, i), there, fishes.period)
            toward = minus(mouth, there)
            flow = suction(toward, fishes.length[i], clock.dt)
            # A fish too large for the mouth resists.
            small = min(FITS * fishes.length[i] / fishes.length[j], 1.0) ** 2
            for axis in range(3):
                fishes.drift[j, axis] += np.float32(small * flow[axis])
            within = MOUTH_BL * fishes.length[i] + MIDDLE * fishes.length[j]
            free = j != sea.catch[1]  # not on the hook
            if minds.kind[j] == PREY and free and small == 1.0 and norm(toward) < within:
                _swallow(fishes, minds, i, j, clock)
    for k in range(len(sea.plankton)):
        there = vector(sea.plankton[k])
        for m in range(np.searchsorted(x, there[0] - farthest), len(mouths)):
            if x[m] > there[0] + farthest:
                break
            i = mouths[m]
            flow = suction(minus(mouth_of(fishes, i), there), fishes.length[i], clock.dt)
            for axis in range(3):
                sea.plankton[k, axis] += np.float32(flow[axis] * clock.dt)


@kernel
def _open_mouths(fishes: Fishes, minds: Minds) -> tuple[Ints, Array]:
    """Hunters with open mouths, and the x of these, sorted by x."""
    mouths, x = np.empty(len(fishes.gape), np.int64), np.empty(len(fishes.gape))
    count = 0
    for i in range(len(fishes.gape)):
        hunts = minds.kind[i] == PREDATOR and minds.intention[i] == EAT and fishes.alive[i]
        if not hunts or fishes.gape[i] <= OPEN:
            continue
        here, k = mouth_of(fishes, i)[0], count
        while k > 0 and x[k - 1] > here:
            mouths[k], x[k] = mouths[k - 1], x[k - 1]
            k -= 1
        mouths[k], x[k] = i, here
        count += 1
    return mouths[:count], x[:count]


@kernel
def suction(toward: Vector, length: float, dt: float) -> Vector:
    """Velocity, cm/s, of a thing whose way to the mouth of a hunter of `length` cm is `toward`.

    It falls to zero at the reach of the suction, and carries nothing past the mouth in `dt` s.
    """
    distance, reach = norm(toward), SUCK_BL * length
    if distance >= reach or distance < 1e-6:
        return ZERO
    speed = min(SUCK_BL_S * length * (1.0 - distance / reach), distance / dt)
    return times(speed / distance, toward)


@kernel
def _swallow(fishes: Fishes, minds: Minds, i: int, j: int, clock: Clock) -> None:
    """Hunter i eats prey j and shuts its mouth: a strike takes one."""
    remove(fishes, minds, j)
    minds.eaten[i] += 1.0
    minds.last_meal[i] = clock.tick * clock.dt
    minds.fatigue[EAT, i] = 0.0
    minds.target[i] = -1
    minds.misses[i], minds.missed[i] = 0.0, NOBODY
    begin(minds, i, CHEWING)
    minds.lull[i] = CHEW_S + _lull(minds, i, 1, clock)
    fishes.gape[i] = 0.0
