"""Every array that changes. One fish is one index in [0, n).

Arrays are plain numpy, so that any kernel accepts them. `docs/state.md` lists all of them.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.state.codes import *  # noqa: F403
from subsea.state.declaration import Spec as Spec
from subsea.state.declaration import declared as declared
from subsea.state.declaration import empty as empty
from subsea.state.directions import Directions as Directions
from subsea.state.fishes import Fishes as Fishes
from subsea.state.live import Live as Live
from subsea.state.minds import TRAITS as TRAITS
from subsea.state.minds import Minds as Minds
from subsea.state.parameters import Clock as Clock
from subsea.state.parameters import Nature as Nature
from subsea.state.parameters import Physics as Physics
from subsea.state.sea import Reef as Reef
from subsea.state.sea import Sea as Sea
from subsea.state.sea import Seaweed as Seaweed
from subsea.state.submarine import Submarine as Submarine


@dataclass
class State:
    """The world at a tick. Snapshots and checksums keep the order of these groups."""

    tick: int
    seed: int
    fishes: Fishes
    minds: Minds
    sea: Sea
    seaweed: Seaweed
    live: Live
    reef: Reef
    directions: Directions
    submarine: Submarine


GROUPS: dict[str, Any] = {
    field.name: field.type for field in fields(State) if field.type is not int
}


def arrays(state: State) -> Iterator[tuple[str, NDArray[Any], Spec]]:
    """Name such as `fishes.position`, array and declaration of everything in a state, no copies.

    Numbers are arrays without a dimension.
    """
    for part, group in GROUPS.items():
        for name, spec in declared(group).items():
            yield f"{part}.{name}", np.asarray(getattr(getattr(state, part), name)), spec
