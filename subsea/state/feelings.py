"""Feelings of a fish for single others and for the submarine (Tu ch. 11, emotion).

Unlike a habit, a feeling is about one individual. A fish holds a few of them, from -1 (dislike) to
1 (liking), and forgets them over minutes.
"""

import numpy as np

from subsea.base.arrays import Ints
from subsea.kernels import kernel
from subsea.state.codes import NOBODY, SUBMARINE
from subsea.state.groups import Minds, Nature

FADING_S = 150.0  # time in which a feeling falls to 1/e
WARY = 0.5  # share by which entire dislike adds to the distance from which a predator is feared
FORGOTTEN = 0.05  # strength below which a feeling is gone


@kernel
def feel(minds: Minds, i: int, j: int, change: float) -> None:
    """Add `change` to what fish i feels for j, a fish or SUBMARINE; at most 1 in strength.

    A new feeling takes a free slot, or that of the weakest feeling if it is stronger. Writes only
    row i.
    """
    slots, weakest = minds.liked.shape[1], 0
    for k in range(slots):
        if minds.liked[i, k] == j:
            minds.liking[i, k] = min(max(minds.liking[i, k] + change, -1.0), 1.0)
            return
        if abs(minds.liking[i, k]) < abs(minds.liking[i, weakest]):
            weakest = k
    if j != NOBODY and abs(change) > abs(minds.liking[i, weakest]):
        minds.liked[i, weakest] = j
        minds.liking[i, weakest] = min(max(change, -1.0), 1.0)


@kernel
def feeling_for(minds: Minds, i: int, j: int) -> float:
    """Return what fish i feels for j, a fish or SUBMARINE: -1 to 1, 0 for strangers."""
    for k in range(minds.liked.shape[1]):
        if minds.liked[i, k] == j:
            return float(minds.liking[i, k])
    return 0.0


@kernel
def fade_feelings(who: Ints, minds: Minds) -> None:
    """Let the feelings of the fishes `who` fade by the time since their last turn."""
    for i in who:
        for k in range(minds.liked.shape[1]):
            if minds.liked[i, k] != NOBODY:
                minds.liking[i, k] *= np.float32(np.exp(-minds.pause[i] / FADING_S))
                if abs(minds.liking[i, k]) < FORGOTTEN:
                    minds.liked[i, k] = NOBODY
                    minds.liking[i, k] = 0.0


@kernel
def dread_of(minds: Minds, i: int, j: int, nature: Nature) -> float:
    """Return D0 of fish i for predator j or SUBMARINE, cm: by its timidity and feeling for it.

    That of the submarine falls as the fish grows used to it.
    """
    dread = float(minds.dread[i])
    if j == SUBMARINE:
        dread = nature.submarine_cm * float(minds.hull_dread[i])
    feeling = feeling_for(minds, i, j)
    wary = 1.0 - (WARY if feeling < 0.0 else 1.0) * feeling
    return dread * float(minds.timidity[i]) * wary
