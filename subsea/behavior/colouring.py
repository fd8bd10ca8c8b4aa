"""Mating colours: males show them while they court (Tu §5.3)."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.kernels import kernel
from subsea.state import NO_COURTSHIP, Clock, Fishes, Minds

EASE_S = 0.7  # time constant: 95% of a change is done after 2 s


@kernel
def ease_display(who: Ints, fishes: Fishes, minds: Minds, clock: Clock) -> None:
    """Ease the display of the fishes `who` toward 1 where a male courts, toward 0 elsewhere."""
    share = 1.0 - np.exp(-clock.dt / EASE_S)
    for i in who:
        courts = fishes.alive[i] and minds.male[i] and minds.courtship[i] != NO_COURTSHIP
        fishes.display[i] += share * ((1.0 if courts else 0.0) - fishes.display[i])
