"""A sea and fishes in it, for tests of what they want."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from subsea.behavior.table import BEHAVIORS, DESIRES
from subsea.scenario import Temper
from subsea.state import (
    NOBODY,
    STOWED,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
    empty_fishes,
    empty_minds,
)

RADIUS, DEPTH, TICK = 1000.0, 600.0, 0.033
FLOOR = np.full((9, 9), -DEPTH, np.float32)


class Tank(NamedTuple):
    """What every desire and routine is given."""

    fishes: Fishes
    minds: Minds
    sea: Sea
    nature: Nature
    clock: Clock

    def at(self, tick: int) -> "Tank":
        """The same at another tick."""
        return self._replace(clock=Clock(self.clock.seed, tick, TICK))

    def run(self, routine: Any, *who: int) -> None:
        """Let a routine act on the fishes `who`, or on all."""
        chosen = np.array(who if who else range(len(self.fishes.species)), np.int64)
        routine(chosen, *self)

    def desire(self, function: Any) -> np.ndarray:
        """What a desire says of each fish."""
        out = np.zeros(len(self.fishes.species), np.float32)
        function(np.arange(len(out)), *self, out)
        return out


def make_tank(
    n: int = 1, seed: int = 1, specks: int = 0, pillars: Any = (), rocks: Any = (), **nature: float
) -> Tank:
    """`n` fishes of 20 cm in the middle of a flat sea, bound along x at 15 cm/s."""
    fishes, minds = empty_fishes(n), empty_minds(n, len(BEHAVIORS), len(DESIRES))
    fishes.length[:] = 20.0
    fishes.snout[:] = 7.0
    fishes.position[:] = 0.0, 0.0, -300.0
    # Upright, along x: body y is up, body z to the right.
    fishes.orientation[:] = np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0
    fishes.velocity[:] = 15.0, 0.0, 0.0
    fishes.goal_direction[:] = 1.0, 0.0, 0.0
    fishes.goal_speed[:] = 0.5
    minds.urge[:] = 1.0, 0.0, 0.0
    minds.waypoint[:] = fishes.position
    minds.pause[:] = TICK
    minds.dread[:] = 200.0
    sea = Sea(
        heights=FLOOR, half_width=1.6 * RADIUS, radius=RADIUS,
        pillars=np.array(pillars, np.float64).reshape(-1, 4),
        rocks=np.array(rocks, np.float64).reshape(-1, 7),
        climate=np.array([27.0, 21.0, DEPTH, 700.0]),
        plankton=np.zeros((specks, 3), np.float32), absent=np.zeros(specks, np.float32),
        seaweed=np.zeros((0, 6), np.float32),
        tackle=np.array([0.0, 0.0, 0.0, 0.0, np.inf]), hook=np.zeros(3),
        catch=np.array([STOWED, NOBODY]),
        submarine=np.array([0.0, 0.0, 1e6, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
    )  # fmt: skip
    constants = {name: getattr(Temper(), name) for name in Nature._fields}
    return Tank(fishes, minds, sea, Nature(**(constants | nature)), Clock(seed, 1, TICK))


@pytest.fixture(scope="session")
def tank() -> Any:
    """The tank itself, for a number of fishes, specks and solids."""
    return make_tank
