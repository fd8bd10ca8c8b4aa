"""Food from the submarine: a pinch of specks before its window, for the fishes around."""

import numpy as np

from subsea.geometry.noise import uniform
from subsea.geometry.vector import Vector, plus, store, times, vector
from subsea.habitat.contact import is_free
from subsea.habitat.plankton import SINKS_S
from subsea.submarine.vessel import hull_axes
from subsea.world.world import World

PINCH = 16  # specks
EVERY_S = 4.0  # shortest time from pinch to pinch
AHEAD_CM, SPREAD_CM = 170.0, 35.0  # place of the specks before the middle of the hull
TRIES = 8  # places tried for a speck
FOOD_PURPOSE = np.int64(200)  # key of the random numbers, for each axis of each attempt


def scatter_food(world: World) -> bool:
    """Scatter a pinch of food before the submarine, between two ticks.

    Specks that were eaten come back as food, then those farthest away; their number stays the
    same. Returns False without plankton, or too soon after the last pinch.
    """
    sea, submarine = world.state.sea, world.state.submarine
    if len(sea.plankton) == 0 or sea.absent.min() < EVERY_S - SINKS_S:
        return False
    away = np.linalg.norm(sea.plankton - submarine.position, axis=1)
    away[sea.absent > 0.0] = np.inf
    middle = plus(vector(submarine.position), times(AHEAD_CM, hull_axes(*submarine.angles)[0]))
    for k in np.argsort(-away, kind="stable")[:PINCH].tolist():
        store(sea.plankton[k], _place(world, middle, k))
        sea.absent[k] = -SINKS_S
    return True


def _place(world: World, middle: Vector, speck: int) -> Vector:
    """Draw a place in free water near the middle, or before the window itself."""
    state, sea = world.state, world.state.sea
    for attempt in range(TRIES):
        x, y, z = (
            SPREAD_CM
            * (
                2.0 * uniform(state.seed, speck, state.tick, FOOD_PURPOSE + 3 * attempt + axis)
                - 1.0
            )
            for axis in range(3)
        )
        place = plus(middle, (x, y, z))
        inside = np.hypot(place[0], place[1]) < sea.radius and place[2] < 0.0
        if inside and is_free(sea.pillars, sea.rocks, place):
            return place
    return vector(state.submarine.position)
