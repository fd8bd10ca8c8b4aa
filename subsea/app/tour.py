"""The autopilot of films and benchmarks: visit the fishes, keep a polite distance."""

import math

import numpy as np

from subsea.submarine.helm import Helm
from subsea.submarine.hull import MAX_PITCH
from subsea.world import TICK_S, World

DISTANCE_CM = 170.0  # close enough to see a fish's eye, far enough not to crowd it
STROLL_S = 23.0  # period of the slow swing around the fishes
STROLL_RAD = 0.35


def tour_helm(world: World) -> Helm:
    """What a pilot with time to look asks for at this tick: a pure function of the world.

    It heads for the middle of the largest shoal, swings slowly from side to side, and slows
    down when near. Without fishes it cruises.
    """
    boat, fishes = world.state.submarine, world.state.fishes
    if len(fishes.position) == 0:
        return Helm(surge=0.3, yaw=0.1)
    largest = np.bincount(fishes.species).argmax()
    # The median ignores a straggler that would drag the mean away from the shoal.
    middle = np.median(fishes.position[fishes.species == largest], axis=0).astype(np.float64)
    offset = middle - boat.position
    level = math.hypot(offset[0], offset[1])
    swing = STROLL_RAD * math.sin(math.tau * world.state.tick * TICK_S / STROLL_S)
    bearing = math.atan2(offset[1], offset[0]) + swing - boat.angles[0]
    bearing = math.remainder(bearing, math.tau)
    pitch = math.atan2(offset[2], max(level, DISTANCE_CM))
    return Helm(
        surge=float(np.clip((level - DISTANCE_CM) / 400.0, -0.3, 0.45)) * math.cos(bearing / 2),
        yaw=float(np.clip(0.9 * bearing - 0.5 * boat.rates[0], -0.6, 0.6)),
        pitch=float(np.clip(pitch / MAX_PITCH, -0.5, 0.5)),
        heave=float(np.clip(offset[2] / 300.0, -0.4, 0.4)),
    )
