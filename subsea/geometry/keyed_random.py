"""Random numbers from keys, independent of order and threads."""

import numpy as np
from numba import uint64

from subsea.kernels import kernel


@kernel
def uniform(seed: int, fish: int, tick: int, purpose: int) -> float:
    """A number in [0, 1) that depends only on the four keys (SplitMix64 finaliser).

    A constant `purpose` is an np.int64; numba would compile this again for each plain one.
    """
    z = uint64(seed) * uint64(0x9E3779B97F4A7C15)
    for key in (fish, tick, purpose):
        z = (z ^ uint64(key)) + uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB)
        z = z ^ (z >> uint64(31))
    return np.float64(z >> uint64(11)) * 2.0**-53
