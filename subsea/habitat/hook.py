"""A baited hook that sinks on a line and is drawn up with its catch (Tu §10.1)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.kernels import kernel
from subsea.scenario.schema import Hook
from subsea.state import HANGING, HOOKED, LANDED, SINKING, STOWED, Clock, Sea

OUT_CM = 60.0  # height above the surface at which it is out of sight


def hook_constants(plan: Hook | None, waits: bool = False) -> NDArray[np.floating[Any]]:
    """The constants of a hook (5,): x, y, depth, cm, speed, cm/s, start, s.

    Without a hook, or where it `waits` for a direction, the start is infinite.
    """
    if plan is None:
        return np.array([0.0, 0.0, 0.0, 0.0, np.inf])
    start = np.inf if waits else plan.start_s
    return np.array([*plan.position_cm, plan.depth_cm, plan.speed_cm_s, start])


@kernel
def move_hook(sea: Sea, clock: Clock) -> None:
    """Move the hook by one tick: down until it hangs, up once it has caught a fish."""
    x, y, depth, speed, start = sea.tackle
    state = sea.catch[0]
    if state == STOWED and clock.tick * clock.dt >= start:
        sea.hook[0], sea.hook[1], sea.hook[2] = x, y, 0.0
        sea.catch[0] = SINKING
    elif state == SINKING:
        sea.hook[2] = max(sea.hook[2] - speed * clock.dt, -depth)
        if sea.hook[2] == -depth:
            sea.catch[0] = HANGING
    elif state == HOOKED:
        sea.hook[2] += speed * clock.dt
        if sea.hook[2] > OUT_CM:
            sea.catch[0] = LANDED
