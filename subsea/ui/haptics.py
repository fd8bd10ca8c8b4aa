"""The pulses that a diver feels in both hands: knocks of the hull, and a shark that passes."""

import numpy as np

from subsea.base.arrays import Array
from subsea.state import PREDATOR
from subsea.view.rig import CameraPose
from subsea.world.world import TICK_S, World

PUSH_CM, FULL_PUSH_CM = 0.5, 4.0  # by which a solid moves the hull in a tick: felt; strongest
NEAR_CM = 250.0  # distance of a shark that is felt
SHARK_LENGTH_CM = 80.0  # of the smallest hunter that is felt
STRONGEST_PASS = 0.35


def hand_pulses(world: World, pilot: CameraPose) -> Array:
    """Strengths (2,) of the pulses in the left and right hand over the last tick, in [0, 1]."""
    submarine, fishes = world.state.submarine, world.state.fishes
    moved = submarine.position - submarine.previous_position
    push = float(np.linalg.norm(moved - TICK_S * submarine.velocity))
    knock = min(push / FULL_PUSH_CM, 1.0) if push > PUSH_CM else 0.0
    strengths = np.full(2, knock)
    big = fishes.alive & (world.state.minds.kind == PREDATOR) & (fishes.length > SHARK_LENGTH_CM)
    for i in np.flatnonzero(big):
        away = fishes.position[i] - pilot.eye
        near = STRONGEST_PASS * max(1.0 - float(np.linalg.norm(away)) / NEAR_CM, 0.0)
        side = int(away @ np.cross(pilot.forward, pilot.up) > 0.0)
        strengths[side] = max(strengths[side], near)
    return strengths
