"""Follow an odour: surge upstream while it is smelled, cast across the stream once it is lost.

So sharks, crabs and moths find the source of a plume (Vickers, Biol. Bull. 198:203, 2000).
"""

import numpy as np

from subsea.geometry.vector import Vector, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import BAIT_ODOUR, BLOOD, HUNGER, PATROLLING, PREDATOR, Fishes, Minds

SMELLS = 2e-3  # 1/m³, least odour that a fish follows
LOST_S = 25.0  # how long it searches for an odour that it lost
CAST_S = 3.0  # time of the first cast; each is longer by as much
UPWARD = 0.3  # part of a cast that leads upstream
STREAM_CM_S = 3.0  # current at which its direction counts as much as that of the odour
PACE = 0.6  # share of the fastest speed
HUNGRY = 0.25  # hunger above which a fish follows


@kernel
def follows(minds: Minds, i: int) -> bool:
    """True if fish i is a scavenger that wants to find food."""
    if not minds.scavenges[i] or minds.mental[i, HUNGER] <= HUNGRY:
        return False
    return minds.kind[i] != PREDATOR or (minds.hunt[i] == PATROLLING and minds.lull[i] <= 0.0)


@kernel
def is_on_trail(minds: Minds, i: int) -> bool:
    """True if fish i smells food or blood that it wants to find."""
    smells = max(minds.scent[i, BAIT_ODOUR], minds.scent[i, BLOOD]) > SMELLS
    return smells and follows(minds, i)


@kernel
def track(fishes: Fishes, minds: Minds, i: int, way: Vector) -> tuple[Vector, bool]:
    """The direction of fish i that heads along `way` unless it follows an odour; if it does."""
    if is_on_trail(minds, i):
        minds.trail[i] = 0.0
    else:
        minds.trail[i] += minds.pause[i]
    if minds.trail[i] > LOST_S or not follows(minds, i):
        return way, False
    water = vector(fishes.drift[i])
    flow = norm(water)
    upstream = times(-1.0 / max(flow, 1e-6), water)
    if minds.trail[i] <= 0.0:
        weight = min(flow / STREAM_CM_S, 1.0)
        return plus(vector(minds.richer[i]), times(weight, upstream)), True
    # Casts of 3, 6, 9 s: number n ends at CAST_S n (n + 1) / 2.
    number = int(0.5 * (np.sqrt(8.0 * minds.trail[i] / CAST_S + 1.0) - 1.0))
    side = 1.0 if (number + i) % 2 == 0 else -1.0
    if flow < 1e-3:
        return way, True
    across = times(side, (-upstream[1], upstream[0], 0.0))
    return plus(across, times(UPWARD, upstream)), True
