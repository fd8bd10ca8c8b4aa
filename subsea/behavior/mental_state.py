"""Hunger, libido and fear (Tu §7.4)."""

from subsea.base.arrays import Ints
from subsea.kernels import kernel
from subsea.state import FEAR, HUNGER, LIBIDO, PACIFIST, PREY, Clock, Fishes, Minds, Nature

# Tu's p0 = 0.00067 and p1 = 0.0025 per time unit of 0.1 s.
DIGESTION = 0.0067  # 1/s: a meal is digested after 149 s
LIBIDO_RATE = 0.025  # 1/s: libido is full 40 s after a mating
DREAD_CM = 200.0  # D0
FOOD_STIMULUS = (0.05, 0.2)  # q1, q2 in 1/cm: food tempts from 20 cm, fully at 5 cm
MATE_STIMULUS = (0.025, 0.1)


@kernel
def update_mental_state(
    who: Ints, fishes: Fishes, minds: Minds, nature: Nature, clock: Clock
) -> None:
    """Update `minds.mental` of the fishes `who` from what they perceive and remember.

    Only prey fear, and only pacifists court (Tu §7.9). Digested meals are forgotten. Fear set by
    a direction replaces that of what is seen.
    """
    now = clock.tick * clock.dt
    for i in who:
        left = 1.0 - minds.digestion[i] * (now - minds.last_meal[i])
        if left <= 0.0:
            minds.eaten[i] = 0.0
        urge = 1.0 - minds.eaten[i] * left / minds.appetite[i]
        food = nature.hunger_stimulus * stimulus(minds.food_distance[i], *FOOD_STIMULUS)
        hunger = min(max(urge + food, 0.0), 1.0)
        minds.mental[i, HUNGER] = hunger
        minds.mental[i, LIBIDO] = 0.0
        if minds.kind[i] == PACIFIST:
            urge = minds.libido_rate[i] * (now - minds.last_mating[i]) * (1.0 - hunger)
            mate = nature.libido_stimulus * stimulus(minds.mate_distance[i], *MATE_STIMULUS)
            minds.mental[i, LIBIDO] = min(max(urge + mate, 0.0), 1.0)
        fear = minds.fright[i] if minds.fright[i] >= 0.0 else minds.menaces[i]
        minds.mental[i, FEAR] = min(fear, 1.0) if minds.kind[i] == PREY else 0.0


@kernel
def stimulus(distance: float, low: float, high: float) -> float:
    """S of a thing at `distance` cm: 0 while 1/distance is below `low`, 1 above `high` (1/cm)."""
    strength = 1.0 / max(distance, 1e-6)
    if strength <= low:
        return 0.0
    if strength >= high:
        return 1.0
    return (strength - low) / (2.0 * high - low - strength)
