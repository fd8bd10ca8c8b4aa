"""Eating: predators hunt, others chase a speck of plankton and suck it in (Tu §7.8).

A fish of an anemone stays about it. Where no speck drifts by, it picks what is too small to draw.
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.biting import approach, in_reach, is_offered
from subsea.behavior.chasing import chase, mouth_of
from subsea.behavior.hunting import EAGER, hunt
from subsea.behavior.hunting import OPEN_BL as HUNTERS_OPEN_BL
from subsea.behavior.hunting import hunger as hunters_hunger
from subsea.behavior.picking import pick_at_home, picks_at_home
from subsea.behavior.schooling import straggles
from subsea.behavior.threat_memory import wariness
from subsea.behavior.wandering import is_at_home, wander
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.state import (
    CHEWING,
    EAT,
    HUNGER,
    PREDATOR,
    SUBMARINE,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.feelings import feel
from subsea.state.places import place_near
from subsea.state.wants import TEMPTING, is_tempted

STILL_KEEN = 0.6  # share of `keen` below which a fish that eats stops
# Food for which a fish of a school turns aside: within this distance and angle ahead.
BROWSE_BL, BROWSE_COS = 4.5, np.cos(np.radians(50.0))
OPEN_BL = 0.5  # distance of the speck at which the mouth begins to open
SUCK_BL = 0.28  # reach of the suction ...
SUCK_CM_S = 25.0  # ... and its speed
SWALLOW_BL = 0.06  # distance at which a speck is in the mouth
SNACK = 0.25  # of a meal, that a speck is to a fish that feeds on stone
ABSENCE_S = (40.0, 90.0)  # until a speck that was eaten is replaced
FED_CM, FED = 250.0, 0.12  # distance of a meal to the submarine, and the liking that it adds
ABSENCE_PURPOSE = np.int64(60)  # key of the random numbers


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Hunger, where it exceeds `keen` and there is food."""
    bait, now = is_offered(sea), clock.tick * clock.dt
    for i in who:
        if minds.kind[i] == PREDATOR:
            out[i] = hunters_hunger(minds, i, nature)
            continue
        hunger = minds.mental[i, HUNGER]
        eats = minds.intention[i] == EAT
        tempted = is_tempted(minds, i, sea, nature)
        least = nature.keen * (TEMPTING if tempted else STILL_KEEN if eats else 1.0)
        # Where it has food on stone, a grazer leaves plankton alone.
        near = minds.food[i] >= 0 and minds.site[i] < 0
        near = near and is_at_home(minds, i, vector(sea.plankton[minds.food[i]]))
        if near and not tempted and minds.schools[i] and (minds.leader[i] >= 0 or minds.leads[i]):
            near = _on_the_way(fishes, minds, i, sea, eats, now)
        bites = bait and in_reach(fishes, minds, i, sea, nature)
        food = near or picks_at_home(minds, i) or (bites and is_at_home(minds, i, vector(sea.hook)))
        # Wary fishes stop feeding before they flee, except of the submarine that feeds them.
        if not (tempted and minds.predator[i] == SUBMARINE):
            least += (1.0 - least) * wariness(minds, i, nature)
        out[i] = max(hunger, EAGER * nature.keen) if hunger > least and food else 0.0


@kernel
def _on_the_way(fishes: Fishes, minds: Minds, i: int, sea: Sea, eats: bool, now: float) -> bool:
    """True if the nearest speck is near and ahead enough for a fish in a school.

    Never for a straggler, which catches up first.
    """
    if straggles(fishes, minds, i, now):
        return False
    toward = minus(vector(sea.plankton[minds.food[i]]), vector(fishes.position[i]))
    distance = norm(toward)
    ahead = x_axis(fishes.orientation[i])
    reach = BROWSE_BL * fishes.length[i] * (1.3 if eats else 1.0)
    aside = 0.0 if eats else BROWSE_COS
    return distance < reach and dot(toward, ahead) > aside * distance


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Hunt, bite, or chase the target speck and open the mouth once it is near."""
    bait = is_offered(sea)
    for i in who:
        if minds.kind[i] == PREDATOR:
            hunt(fishes, minds, i, sea, clock)
            continue
        if bait and in_reach(fishes, minds, i, sea, nature):
            approach(fishes, minds, i, sea)
            continue
        k = minds.target[i]
        if k < 0 or sea.absent[k] > 0.0 or not is_at_home(minds, i, vector(sea.plankton[k])):
            if not picks_at_home(minds, i):
                wander(fishes, minds, i, sea, clock)
                continue
            distance = pick_at_home(fishes, minds, i, sea, clock)
        else:
            distance = chase(fishes, minds, i, vector(sea.plankton[k]), ZERO)
        fishes.gape[i] = _gape_at(distance / fishes.length[i])


@kernel
def _gape_at(distance_bl: float) -> float:
    """Opening of the mouth for a speck at a distance in body lengths."""
    return min(max(1.0 - (distance_bl - SUCK_BL) / (OPEN_BL - SUCK_BL), 0.0), 1.0)


@kernel
def snap(i: int, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Let fish i eat its nearest food if that is before its mouth, without heading for it."""
    k, mouth = minds.food[i], mouth_of(fishes, i)
    if k < 0:
        return
    if minds.kind[i] == PREDATOR:
        distance = norm(minus(place_near(fishes, k, mouth), mouth)) / fishes.length[i]
        ready = fishes.alive[k] and minds.hunt[i] != CHEWING
        gape = 1.0 if ready and distance < HUNTERS_OPEN_BL else 0.0
    else:
        distance = norm(minus(vector(sea.plankton[k]), mouth)) / fishes.length[i]
        gape = _gape_at(distance) if sea.absent[k] <= 0.0 else 0.0
    if gape > 0.0:
        minds.intention[i], minds.target[i] = EAT, k
        fishes.gape[i] = gape


@kernel
def ingest(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Draw specks into open mouths and eat those inside; runs every tick."""
    for i in range(len(minds.intention)):
        k = minds.target[i]
        if minds.intention[i] != EAT or minds.kind[i] == PREDATOR or k < 0:
            continue
        if sea.absent[k] > 0.0 or fishes.gape[i] <= 0.0:
            continue
        toward = minus(mouth_of(fishes, i), vector(sea.plankton[k]))
        distance = norm(toward)
        if distance < SUCK_BL * fishes.length[i]:
            step = min(SUCK_CM_S * clock.dt / max(distance, 1e-6), 1.0)
            for axis in range(3):
                sea.plankton[k, axis] += np.float32(step * toward[axis])
            distance *= 1.0 - step
        if distance < SWALLOW_BL * fishes.length[i]:
            low, high = ABSENCE_S
            share = uniform(clock.seed, np.int64(k), clock.tick, ABSENCE_PURPOSE)
            sea.absent[k] = low + (high - low) * share
            minds.eaten[i] += SNACK if minds.diet[i] else 1.0
            minds.last_meal[i] = clock.tick * clock.dt
            minds.fatigue[EAT, i] = 0.0
            minds.target[i] = -1
            hull = vector(sea.submarine)
            if norm(minus(hull, vector(fishes.position[i]))) < FED_CM:
                feel(minds, i, SUBMARINE, FED)
