"""Save and restore parameters that panels edit.

A snapshot holds all that a tick changes. Both together are the complete state of a world.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.state import TRAITS, Nature, Physics
from subsea.world.world import World


class Tunables(NamedTuple):
    """A copy of the parameters that panels edit."""

    nature: Nature
    current_cm_s: tuple[float, float]  # strength of the swinging current along x and y
    physics: Physics  # of simulated fishes
    traits: dict[str, NDArray[Any]]  # by the names in `state.TRAITS`


def get_tunables(world: World) -> Tunables:
    """Copy the parameters of a world."""
    traits = {name: getattr(world.state.minds, name).copy() for name in TRAITS}
    return Tunables(world.nature, world.current_cm_s, world.physics, traits)


def set_tunables(world: World, tunables: Tunables) -> None:
    """Restore the parameters of a world.

    Call it before `snapshot.restore`: the values allowed in a snapshot depend on the traits.
    """
    world.nature, world.current_cm_s, world.physics = tunables[:3]
    for name, values in tunables.traits.items():
        getattr(world.state.minds, name)[...] = values


def equal_tunables(one: Tunables, other: Tunables) -> bool:
    """True if worlds with these parameters continue equally from the same snapshot."""
    return one[:3] == other[:3] and all(
        np.array_equal(values, other.traits[name]) for name, values in one.traits.items()
    )
