"""The autopilot of films and benchmarks: visit the fishes, keep a polite distance."""

import math

import numpy as np

from subsea.submarine.helm import Helm
from subsea.submarine.hull import MAX_PITCH
from subsea.world import TICK_S, World

# Close enough to see a fish's eye, far enough not to crowd it. Three slow swings with periods
# that do not meet keep the view moving while the fishes hover.
DISTANCE_CM, NEARER_CM, NEARER_S = 200.0, 70.0, 31.0
ASIDE_RAD, ASIDE_S = 0.30, 23.0
ABOVE_CM, ABOVE_S = 45.0, 17.0


def tour_helm(world: World) -> Helm:
    """What a pilot with time to look asks for at this tick: a pure function of the world.

    It faces the middle of the largest shoal and follows it, now nearer, now farther, a little
    to the side, a little above. Without fishes it cruises.
    """
    boat, fishes = world.state.submarine, world.state.fishes
    if len(fishes.position) == 0:
        return Helm(surge=0.3, yaw=0.1)
    now = world.state.tick * TICK_S
    largest = np.bincount(fishes.species).argmax()
    # The median ignores a straggler that would drag the mean away from the shoal.
    middle = np.median(fishes.position[fishes.species == largest], axis=0).astype(np.float64)
    x, y, z = middle - boat.position
    level = math.hypot(x, y)
    distance = DISTANCE_CM - NEARER_CM * _swing(now, NEARER_S)
    bearing = math.atan2(y, x) + ASIDE_RAD * _swing(now, ASIDE_S) - boat.angles[0]
    bearing = math.remainder(bearing, math.tau)
    pitch = math.atan2(z, max(level, DISTANCE_CM))
    return Helm(
        surge=_within((level - distance) / 400.0, -0.3, 0.45) * math.cos(bearing / 2.0),
        yaw=_within(0.9 * bearing - 0.5 * boat.rates[0], -0.6, 0.6),
        pitch=_within(pitch / MAX_PITCH, -0.5, 0.5),
        heave=_within((z + ABOVE_CM * _swing(now, ABOVE_S)) / 200.0, -0.4, 0.4),
    )


def _swing(now: float, period: float) -> float:
    return math.sin(math.tau * now / period)


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
