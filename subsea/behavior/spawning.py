"""Spawning: a burst upward, side by side, and the release at its peak (Tu §7.9.3), or a nest.

Pairs of reef fishes dash up by some lengths within seconds, release, and dash down again
(Thresher 1984). Fishes with an anemone lay on stone beside it (`laying.py`).
"""

import numpy as np

from subsea.base.arrays import Bools, Ints
from subsea.behavior.chasing import burst, set_urge
from subsea.behavior.laying import LAYS_S, lay, nest_of
from subsea.behavior.manoeuvring import heading_of, scull
from subsea.geometry.vector import dot, minus, plus, unit, vector
from subsea.kernels import kernel
from subsea.state import Clock, Fishes, Minds, Sea

RUSH_S = 1.6  # how long it lasts
STEEP = 1.4  # slope of the urge: the motor system turns as far up as it can
BESIDE = 0.8  # of the mean width of both bodies, from middle to middle, and ...
BESIDE_BL = 0.12  # ... of their mean length
LIFT_BL_S, JOINING_BL_S = 0.8, 1.0  # by fins: how fast both rise, and he keeps beside her
WAITS_BL, WAITS, LEAST = 0.3, 0.8, 0.3  # the one ahead slows down: from where, slope, least share
CEILING_BL, CEILING_CM = 0.8, 6.0  # depth under the surface at which it ends


@kernel
def rush(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Both lay on her nest, or burst upward on her course; he keeps beside her, as fast as she."""
    for i in who:
        j = np.int64(minds.partner[i])
        her = j if minds.male[i] else i
        nest = nest_of(minds, her, sea)
        if nest >= 0:
            lay(fishes, minds, sea, clock, i, nest)
            continue
        course = heading_of(fishes, her)
        set_urge(minds, i, (np.cos(course), np.sin(course), STEEP))
        burst(fishes, minds, i)
        # Neither leaves the other behind.
        theirs = max(fishes.burst[j], np.float32(1.0)) * fishes.fast[j]
        gap = minus(vector(fishes.position[i]), vector(fishes.position[j]))
        ahead = dot(gap, unit(vector(minds.urge[i]))) / float(fishes.length[i])
        share = min(max(1.0 - WAITS * (ahead - WAITS_BL), LEAST), 1.0)
        fishes.goal_speed[i] = min(fishes.goal_speed[i], share * theirs / fishes.fast[i])
        length = float(fishes.length[i])
        scull(fishes, i, (0.0, 0.0, 1.0 * length), LIFT_BL_S)
        if minds.male[i]:
            left = -np.sin(course) * gap[0] + np.cos(course) * gap[1]
            room = BESIDE * 0.5 * (fishes.girth[i, 1] + fishes.girth[j, 1])
            room += BESIDE_BL * 0.5 * (length + fishes.length[j])
            room = room if left >= 0.0 else -room
            beside = (-room * np.sin(course), room * np.cos(course), 0.0)
            place = plus(vector(fishes.position[j]), beside)
            scull(fishes, i, minus(place, vector(fishes.position[i])), JOINING_BL_S)


@kernel
def spawned(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """True if she has laid or rushed for long enough, or is near the surface."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        i = who[k]
        if nest_of(minds, i, sea) >= 0:
            done[k] = not minds.male[i] and minds.courtship_count[i] > LAYS_S
            continue
        ceiling = -CEILING_BL * fishes.length[i] - CEILING_CM
        late = minds.courtship_time[i] > RUSH_S or fishes.position[i, 2] > ceiling
        done[k] = not minds.male[i] and late
    return done
