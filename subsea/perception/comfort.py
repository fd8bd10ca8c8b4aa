"""Depths at which a fish likes the light and the warmth (Tu §7.3)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.kernels import kernel
from subsea.state import BRIGHTNESS, COLD, DARKNESS, WARMTH, Minds, Nature
from subsea.state.habits import depth_of_light, dusk_of, mild_of, wish


@kernel
def sense_comfort(who: Ints, minds: Minds, climate: Array, nature: Nature) -> None:
    """Set `minds.comfort` of the fishes `who`: depths between which they are content, cm.

    Habits that contradict each other, as brightness and cold, meet half way.
    """
    for i in who:
        top, bottom = 0.0, np.inf
        light, warmth = wish(minds, i, BRIGHTNESS, DARKNESS), wish(minds, i, WARMTH, COLD)
        if light != 0.0:
            depth = depth_of_light(dusk_of(minds, i, nature), climate)
            if light > 0.0:
                bottom = depth
            else:
                top = depth
        if warmth != 0.0 and climate[0] != climate[1]:
            share = mild_of(minds, i, nature)
            depth = climate[2] * (1.0 - share if climate[0] > climate[1] else share)
            if (warmth > 0.0) == (climate[0] > climate[1]):
                bottom = min(bottom, depth)
            else:
                top = max(top, depth)
        if top > bottom:
            top = bottom = 0.5 * (top + bottom)
        minds.comfort[i, 0], minds.comfort[i, 1] = top, bottom
