"""Hunting: chase prey, open the mouth and suck it in (Tu §7.8.2, §7.9.1)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import burst, chase, mouth_of
from subsea.behavior.death import remove
from subsea.behavior.wandering import wander
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, times, vector
from subsea.kernels import kernel
from subsea.state import EAT, HUNGER, PREDATOR, PREY, Clock, Fishes, Minds, Nature, Sea

STILL_HUNGRY = 0.6  # share of `keen` below which a hunter stops
EAGER = 1.5  # least desire of a hunter over `keen`, so that it does not waver
STALK = 0.7  # share of the fastest speed while it approaches
BURST_BL = 2.5  # distance within which it bursts forward ...
AIM_RAD = np.radians(30.0)  # ... if it heads for the prey, ...
BRAKED = 0.12  # ... else it slows down to turn on the spot
READY_S = 1.5  # spent part of a burst below which it begins to burst
STRAIN = 6.0  # s of fatigue per second of a burst; approach and turns cost none
ATTENTION_TICKS = 20  # until its attention may pass to another fish of a crowd, 0.67 s
CROWD_BL = 5.0  # distance, in lengths of the prey, within which fishes confuse the hunter
ATTENTION_PURPOSE = np.int64(82)  # key of the random numbers
RESTED_S = 25.0  # fatigue below which a hunter that gave up hunts again
CHEW_S = 5.0  # chewing the catch: time for the others to scatter
CHEWS_PER_S = 2.5

FITS = 0.45  # longest prey that it can swallow, over its own length
OPEN_BL = 0.25  # distance to the prey below which a hunter opens its mouth
OPEN = 0.5  # gape above which a mouth draws water in
SUCK_BL = 0.3  # reach of the suction ...
SUCK_BL_S = 2.0  # ... and its speed at the mouth
# Prey is in the mouth when its middle is within these shares of the hunter's and its own length.
MOUTH_BL, MIDDLE = 0.05, 0.2


@kernel
def hunger(minds: Minds, i: int, nature: Nature) -> float:
    """The desire of a predator to hunt: its hunger, unless the last chase tired it."""
    hunts = minds.intention[i] == EAT or minds.memory[i] == EAT
    least = nature.keen * (STILL_HUNGRY if hunts else 1.0)
    tired = not hunts and minds.fatigue[EAT, i] > RESTED_S
    if minds.food[i] < 0 or tired or minds.mental[i, HUNGER] <= least:
        return 0.0
    return max(minds.mental[i, HUNGER], EAGER * nature.keen if hunts else 0.0)


@kernel
def hunt(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> None:
    """Approach, burst forward once near, and open the mouth at the prey.

    Without prey, or while it chews the last one, cruise.
    """
    j = minds.target[i] if minds.target[i] >= 0 else minds.food[i]
    chews = is_chewing(minds, i, clock)
    if j < 0 or not fishes.alive[j] or chews:
        wander(fishes, minds, i, sea, clock)
        if chews:
            since = clock.tick * clock.dt - minds.last_meal[i]
            fishes.gape[i] = 0.15 + 0.15 * np.sin(2.0 * np.pi * CHEWS_PER_S * since)
        return
    length = fishes.length[i]
    sure = True
    if norm(minus(vector(fishes.position[j]), mouth_of(fishes, i))) < BURST_BL * length:
        j, sure = attended(fishes, minds, i, j, companions(fishes, minds, j), clock)
    minds.target[i] = j
    strikes = fishes.goal_speed[i] > 1.0  # since its last decision
    distance = chase(fishes, minds, i, vector(fishes.position[j]), vector(fishes.velocity[j]))
    strain = 0.0
    if distance > BURST_BL * length:
        fishes.goal_speed[i] = STALK
    elif _aside(fishes, minds, i) > AIM_RAD:
        fishes.goal_speed[i] = BRAKED
    else:
        # It waits until it has recovered, or it would use up the little it has at once.
        if strikes or minds.spent[i] < READY_S:
            burst(fishes, minds, i)
            strain = STRAIN
    # The intention generator has already added a second per second.
    fatigue = minds.fatigue[EAT, i] + (strain - 1.0) * minds.pause[i]
    minds.fatigue[EAT, i] = max(fatigue, 0.0)
    gap = norm(minus(vector(fishes.position[j]), mouth_of(fishes, i)))
    fishes.gape[i] = 1.0 if gap < OPEN_BL * length and sure else 0.0


@kernel
def companions(fishes: Fishes, minds: Minds, j: int) -> int:
    """The number of neighbours of fish j that are near enough to confuse its hunter."""
    here, count = vector(fishes.position[j]), 0
    for k in minds.neighbour[j]:
        if k < 0 or norm(minus(vector(fishes.position[k]), here)) > CROWD_BL * fishes.length[j]:
            break
        count += 1
    return count


@kernel
def attended(
    fishes: Fishes, minds: Minds, i: int, j: int, crowd: int, clock: Clock
) -> tuple[int, bool]:
    """The fish that hunter i attends to, and whether it is sure of it.

    For a spell of ATTENTION_TICKS it is drawn to prey j or to one of its `crowd` companions, all
    alike. It opens its mouth only if it stays with its prey, so companions confuse it (Neill and
    Cullen, J. Zool. 172:549, 1974).
    """
    spell = clock.tick // ATTENTION_TICKS
    drawn = int((crowd + 1) * uniform(clock.seed, i, spell, ATTENTION_PURPOSE))
    before = clock.tick - round(minds.pause[i] / clock.dt)  # its last decision
    if drawn == 0 or before // ATTENTION_TICKS == spell:
        return j, drawn == 0
    k = int(minds.neighbour[j, drawn - 1])
    first, end, kind = minds.quarry[i]
    quarry = first <= k < end and (kind < 0 or fishes.species[k] == kind)
    return (k if quarry and fishes.alive[k] and minds.kind[k] == PREY else j), False


@kernel
def is_chewing(minds: Minds, i: int, clock: Clock) -> bool:
    """True if hunter i still chews its last catch."""
    since = clock.tick * clock.dt - minds.last_meal[i]
    return since < CHEW_S and minds.eaten[i] > 0.0 and minds.last_meal[i] > 0.0


@kernel
def _aside(fishes: Fishes, minds: Minds, i: int) -> float:
    """The angle between heading and urge of fish i, rad."""
    ahead, urge = x_axis(fishes.orientation[i]), vector(minds.urge[i])
    return np.arccos(min(max(dot(ahead, urge) / max(norm(urge), 1e-9), -1.0), 1.0))


@kernel
def inhale(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Draw fishes and plankton toward open mouths, and eat prey inside; runs every tick.

    Fishes are moved by their `drift`, specks directly. The mouths are few and sorted along x, so
    that no pass goes over all pairs.
    """
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
        for k in range(np.searchsorted(x, there[0] - farthest), len(mouths)):
            i = mouths[k]
            if x[k] > there[0] + farthest or not fishes.alive[j]:
                break
            if i == j or fishes.gape[i] <= OPEN:  # shut on another since
                continue
            toward = minus(mouth_of(fishes, i), there)
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
    fishes.gape[i] = 0.0
