"""Inspect a predator: bold fishes of a school approach it from the side, and return.

Minnows and guppies leave their school in ones and twos, come near a predator that does not hunt,
and carry news of it back (Pitcher, Green and Magurran, J. Fish Biol. 28:439, 1986).
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import FEAR, PREY, Clock, Fishes, Minds, Nature, Sea
from subsea.state.places import place_near
from subsea.state.schools import known_by

BOLD = 0.15  # share of fishes that inspect
INSPECTED_BL_S = 0.8  # a predator that is faster, in its lengths per second, is not inspected
NOTICED_COS = np.cos(np.radians(40.0))  # cosine of the angle before it in which it notices a fish
UNSHAKEN_S = 10.0  # time since its last start before a fish inspects
EAGERNESS = 0.9  # desire to inspect: more than to close ranks, less than to flee an attack
INSPECTS_S, RESTS_S = 14.0, 60.0  # longest inspection, and time until the next one
NEAREST = 0.92  # share of f1 of the fear at which a fish comes no nearer
PACE = 0.55  # greatest share of the fastest speed
ARRIVED_BL = 1.5  # distance from the place beside the predator at which a fish turns back
BOLDNESS_PURPOSE = np.int64(163)  # key of the random numbers


@kernel
def advance_inspections(
    who: Ints, fishes: Fishes, minds: Minds, nature: Nature, clock: Clock
) -> None:
    """Count the time of inspections, and afterwards of the rest as a negative number.

    Bold fishes in company inspect a calm predator that they see, until they have been near it.
    """
    for i in who:
        spent = float(minds.inspection[i])
        if minds.kind[i] != PREY or (spent == 0.0 and minds.menace[i] <= 0.0):
            continue
        pause = float(minds.pause[i])
        if spent < 0.0:
            spent = min(spent + pause, 0.0)
        elif may_inspect(fishes, minds, i, nature, clock) and spent < INSPECTS_S:
            spent += pause
        elif spent > 0.0:
            spent = -RESTS_S
        minds.inspection[i] = spent


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """EAGERNESS of fishes that inspect a predator."""
    for i in who:
        out[i] = EAGERNESS if minds.kind[i] == PREY and minds.inspection[i] > 0.0 else 0.0


@kernel
def undaunted_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """EAGERNESS of fishes that inspect although their fear is above f0."""
    for i in who:
        alarmed = minds.inspection[i] > 0.0 and minds.mental[i, FEAR] > nature.alarmed
        out[i] = EAGERNESS if alarmed else 0.0


@kernel
def may_inspect(fishes: Fishes, minds: Minds, i: int, nature: Nature, clock: Clock) -> bool:
    """True if fish i is bold and wary, has company, and its predator is calm and minds others."""
    j = int(minds.predator[i])
    if j < 0 or not minds.schools[i] or minds.neighbour[i, 0] < 0:
        return False
    if minds.errand[i] > 0.0 or minds.errand[known_by(minds, i)] > 0.0:
        return False
    if minds.mental[i, FEAR] <= 0.5 * nature.alarmed or minds.menace[i] >= nature.panicked:
        return False
    if minds.startled[i] < UNSHAKEN_S or is_shy(i, clock):
        return False
    if norm(vector(fishes.velocity[j])) > INSPECTED_BL_S * fishes.length[j]:
        return False
    here = vector(fishes.position[i])
    toward = minus(here, place_near(fishes, j, here))
    return dot(toward, x_axis(fishes.orientation[j])) < NOTICED_COS * norm(toward)


@kernel
def is_shy(i: int, clock: Clock) -> bool:
    """True if fish i never inspects: the same fishes throughout a dive."""
    return uniform(clock.seed, i, 0, BOLDNESS_PURPOSE) >= BOLD


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Swim to a place beside the predator; the inspection ends there."""
    for i in who:
        j = int(minds.predator[i])
        if j < 0:
            continue
        here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[j])
        there = place_near(fishes, j, here)
        side = minus(here, there)
        side = minus(side, times(dot(side, ahead), ahead))
        reach = float(minds.dread[i]) / (NEAREST * nature.panicked) / max(norm(side), 1.0)
        place = plus(there, times(reach, side))
        gap = chase(fishes, minds, i, place, vector(fishes.velocity[j]))
        fishes.goal_speed[i] = min(fishes.goal_speed[i], PACE)
        if gap < ARRIVED_BL * fishes.length[i]:
            minds.inspection[i] = INSPECTS_S
