"""What no tick changes, but a panel may while diving: as it is now, and back.

`snapshot` holds all that a tick changes. The two together are a world at a moment.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.state import TRAITS, Nature, Physics
from subsea.world.world import World


class Constants(NamedTuple):
    """A copy: nothing that happens to the world changes it."""

    nature: Nature
    current_cm_s: tuple[float, float]  # strength of the swinging current along x and y
    physics: Physics  # of the fishes that are simulated
    minds: dict[str, NDArray[Any]]  # by the names of `TRAITS`


def constants_of(world: World) -> Constants:
    """The constants of a world as they are now."""
    minds = {name: getattr(world.state.minds, name).copy() for name in TRAITS}
    return Constants(world.nature, world.current_cm_s, world.physics, minds)


def put_back(world: World, constants: Constants) -> None:
    """Give the world the constants that `constants_of` saw in it.

    Before `snapshot.restore` of the same moment: what a snapshot may hold depends on them.
    """
    world.nature, world.current_cm_s, world.physics = constants[:3]
    for name, values in constants.minds.items():
        getattr(world.state.minds, name)[...] = values


def same(one: Constants, other: Constants) -> bool:
    """Whether worlds with these constants go on alike from the same snapshot."""
    return one[:3] == other[:3] and all(
        np.array_equal(values, other.minds[name]) for name, values in one.minds.items()
    )
