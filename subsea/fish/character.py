"""Character: lasting differences between the fishes of a species (Tu §6.6.1, §7.7.3).

Individuals of a school differ steadily in speed, boldness and liking for company, and these
differences explain what the school does (Jolles et al., Curr. Biol. 27:2862, 2017). The traits go
together: bold fishes are more active and less sociable (Sih et al., Trends Ecol. Evol. 19:372,
2004).
"""

from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.geometry.noise import uniform
from subsea.kernels import kernel

MEAN_RANGE = 0.2, 5.0
Trait = tuple[
    Annotated[float, msgspec.Meta(ge=MEAN_RANGE[0], le=MEAN_RANGE[1])],  # mean
    Annotated[float, msgspec.Meta(ge=0, le=1)],  # spread: standard deviation of the logarithm
]
TRAIT_RANGE = 0.1, 10.0  # of the trait of one fish
SYNDROME = {"timidity": -0.6, "activity": 0.6, "sociability": -0.6}  # share of common boldness
FARTHEST = 2.0  # standard deviations by which a fish differs at most
CHARACTER_PURPOSE = np.int64(140)  # key of the random numbers of boldness; traits have the next


class CharacterPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Mean and spread of each trait of a species; 1 is the usual fish."""

    timidity: Trait = (1.0, 0.2)  # keeps farther from collisions, predators and the vessel
    devotion: Trait = (1.0, 0.3)  # keeps its target, though another is nearer
    activity: Trait = (1.0, 0.15)  # swims faster and pauses less
    sociability: Trait = (1.0, 0.2)  # keeps nearer to companions
    appetite: Trait = (1.0, 0.2)  # meals that fill it, over the usual number


def draw_character(
    plan: CharacterPlan, seed: int, first: int, number: int
) -> dict[str, NDArray[np.float32]]:
    """Draw the traits (number,) of the fishes from `first` on, by name.

    A trait is log-normal about its mean. It depends on the seed and the number of the fish alone.
    """
    boldness = _normal(seed, first, number, 0)
    traits = {}
    for key, name in enumerate(msgspec.structs.asdict(plan), start=1):
        mean, spread = getattr(plan, name)
        share = SYNDROME.get(name, 0.0)
        own = _normal(seed, first, number, key)
        deviation = share * boldness + np.sqrt(1.0 - share * share) * own
        deviation = np.clip(deviation, -FARTHEST, FARTHEST)
        traits[name] = np.clip(mean * np.exp(spread * deviation), *TRAIT_RANGE).astype(np.float32)
    return traits


@kernel
def _normal(seed: int, first: int, number: int, key: int) -> NDArray[np.float64]:
    """Draw a standard normal number for each fish (Box and Muller)."""
    drawn = np.empty(number)
    purpose = CHARACTER_PURPOSE + 2 * np.int64(key)
    for k in range(number):
        radius = np.sqrt(-2.0 * np.log(1.0 - uniform(seed, first + k, 0, purpose)))
        angle = 2.0 * np.pi * uniform(seed, first + k, 0, purpose + np.int64(1))
        drawn[k] = radius * np.cos(angle)
    return drawn
