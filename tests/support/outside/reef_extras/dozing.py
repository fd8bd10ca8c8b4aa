"""A behavior of fishes: to doze whenever nothing else is urgent."""

from subsea.base.arrays import Array, Ints
from subsea.behavior.intention import EASE, Behavior
from subsea.kernels import kernel
from subsea.state import Clock, Fishes, Minds, Nature, Sea


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Want to doze, more than to wander."""
    for i in who:
        out[i] = 1.0


@kernel
def doze(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Rest in the water."""
    for i in who:
        fishes.goal_speed[i] = 0.0


DOZE = Behavior("doze", doze, ((EASE, desire),))
