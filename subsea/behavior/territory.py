"""Territories: a resident shows its fins to an intruder, then chases it, and the intruder leaves.

The resident wins whatever their sizes are, as it does on reefs (Fricke 1974; Myrberg and Thresher
1974).
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase, set_urge
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import GUARD, NO_COURTSHIP, NOBODY, Clock, Fishes, Minds, Nature, Sea

ZEAL = 0.9  # desire to drive an intruder off
DISPLAY_S = 1.2  # how long a resident only shows itself
CHASES_S = 3.0  # how long it then chases
RESTS = 15.0  # how many times as long as it guarded it then rests: displays are brief
SHOWS = 0.06  # speed of one that does, share of the fastest
NEAR_BL = 4.0  # distance, over the mean length, at which an intruder feels chased
LEAVES_S = 3.0  # how long it then swims away ...
REMEMBERS_S = 90.0  # ... and looks for no food there
FLEES, HURRIES_BL = 0.75, 2.0  # its speed; nearer than this it is as fast as it can
DESIRE = 0.45  # to leave, among dangers


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Zeal of a resident that sees an intruder and has rested since the last chase."""
    for i in who:
        sees = minds.intruder[i] != NOBODY and minds.courtship[i] == NO_COURTSHIP
        if minds.intention[i] == GUARD:
            sees = sees and minds.held[i] < DISPLAY_S + CHASES_S
        elif minds.memory[i] != GUARD:
            sees = sees and minds.fatigue[GUARD, i] <= 0.0
        out[i] = ZEAL if sees and minds.wary[i] <= 0.0 and minds.errand[i] <= 0.0 else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Face the intruder with raised fins, then chase it. It writes whom the intruder flees from."""
    for i in who:
        j = minds.intruder[i]
        minds.fatigue[GUARD, i] += (RESTS - 1.0) * minds.pause[i]
        here, there = vector(fishes.position[i]), vector(fishes.position[j])
        toward = minus(there, here)
        if minds.held[i] < DISPLAY_S:
            set_urge(minds, i, toward)
            fishes.goal_speed[i] = SHOWS
            continue
        chase(fishes, minds, i, there, vector(fishes.velocity[j]))
        mean = 0.5 * float(fishes.length[i] + fishes.length[j])
        if norm(toward) < NEAR_BL * mean:
            minds.chaser[j], minds.chased[j] = i, LEAVES_S + REMEMBERS_S


@kernel
def yielding_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Haste of a fish that is chased out of a territory, for a while; it remembers whose it is."""
    for i in who:
        if minds.chased[i] > 0.0:
            minds.chased[i] = max(minds.chased[i] - minds.pause[i], np.float32(0.0))
        if minds.chased[i] <= 0.0:
            minds.chaser[i] = NOBODY
        out[i] = DESIRE if minds.chased[i] > REMEMBERS_S else 0.0


@kernel
def give_way(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Swim away from the resident and its home."""
    for i in who:
        j = minds.chaser[i]
        here = vector(fishes.position[i])
        from_home = minus(here, vector(minds.home[j]))
        from_it = minus(here, vector(fishes.position[j]))
        away = plus(
            times(1.0 / max(norm(from_home), 1.0), from_home),
            times(1.0 / max(norm(from_it), 1.0), from_it),
        )
        set_urge(minds, i, away if norm(away) > 1e-3 else x_axis(fishes.orientation[i]))
        fishes.goal_speed[i] = 1.0 if norm(from_it) < HURRIES_BL * fishes.length[i] else FLEES
