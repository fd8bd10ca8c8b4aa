"""The way of the submarine when a tour or a direction steers it: smooth, and clear of solids."""

import itertools
import math

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.solids import height_at
from subsea.geometry.vector import Vector, vector
from subsea.habitat.contact import clearance, out_of_solids, stands_between
from subsea.state import HULL_CM, Submarine
from subsea.submarine.vessel import ACCELERATION_CM_S2, AHEAD_CM_S, keep_clear
from subsea.world.world import TICK_S, World

SHORTEST_S = 1.2  # least time for the rest of a way: smooths the pursuit of fishes
HASTE = 1.6  # peak over mean speed on a way with a smooth start and end
AROUND = [math.radians(side * turn) for turn in range(0, 181, 20) for side in (1, -1)]
# Tangents of the higher views tried around obstacles, then of lower ones, for a subject near the
# surface.
RISES = (0.0, 0.4, 0.9, 1.4, -0.4, -0.9)
FARTHER = 1.0, 1.6, 2.5  # shares of a distance, where it is not free
MARGIN_CM = 10.0  # added to pillars and rocks when they hide something
DETOURS = np.radians([20.0, 35.0, 50.0, 65.0, 80.0])  # tried in turn, to get around an obstacle
DETOUR_CM = 300.0


def hidden(world: World, a: Vector, b: Vector, margin: float) -> bool:
    """True if a pillar or rock lies between a and b, except one that contains b."""
    sea = world.state.sea
    return bool(stands_between(sea.pillars, sea.rocks, a, b, margin))


def beside(world: World, target: Array, way: Array, slope: float, far: float) -> Array:
    """A free place, `far` cm from a target or more, about in direction `way`.

    The submarine's if there is none.
    """
    sea, bounds = world.state.sea, world.scenario.bounds
    bearing = math.atan2(way[1], way[0])
    for more, rise, turn in itertools.product(FARTHER, RISES, AROUND):
        level, ahead = more * far / math.hypot(1.0, slope + rise), bearing + turn
        place = target + level * np.array([math.cos(ahead), math.sin(ahead), slope + rise])
        floor = height_at(sea.floor, sea.half_width, place[0], place[1])
        free = floor + HULL_CM + MARGIN_CM < place[2] < -HULL_CM
        free = free and math.hypot(place[0], place[1]) < bounds.radius_cm - HULL_CM
        free = free and clearance(sea.pillars, sea.rocks, vector(place)) > HULL_CM + MARGIN_CM
        if free and not hidden(world, vector(place), vector(target), MARGIN_CM):
            return place
    return world.state.submarine.position.copy()


def nearer(world: World, place: Array, speed: Array, left_s: float) -> tuple[Array, Array]:
    """Place and velocity a tick later on a smooth way of at least `left_s` seconds.

    The way is the cubic to `place` (3,) with the velocity `speed` (3,) there; it avoids solids.
    """
    boat = world.state.submarine
    if hidden(world, vector(place), vector(boat.position), HULL_CM):
        place, speed = _detour(world, place), np.zeros(3)
    gap = place - boat.position
    left = max(left_s, HASTE * float(np.linalg.norm(gap)) / AHEAD_CM_S, SHORTEST_S)
    push = 6.0 * (gap + left * speed) / left**2 - (4.0 * boat.velocity + 2.0 * speed) / left
    push *= min(1.0, ACCELERATION_CM_S2 / max(float(np.linalg.norm(push)), 1e-9))
    velocity = boat.velocity + TICK_S * push
    velocity *= min(1.0, AHEAD_CM_S / max(float(np.linalg.norm(velocity)), 1e-9))
    later = Submarine(position=boat.position.copy(), velocity=velocity)
    keep_clear(later.position, later.velocity, world.state.sea)
    return clear(world, boat.position + TICK_S * later.velocity), later.velocity


def clear(world: World, place: Array) -> Array:
    """The nearest place that touches nothing."""
    half = 0.5 * HULL_CM
    return np.array(out_of_solids(world.state.sea, vector(place), half, half, half))


def _detour(world: World, place: Array) -> Array:
    """A place on a free way around obstacles between the submarine and a place."""
    sea, boat = world.state.sea, world.state.submarine
    ahead = (place - boat.position) / np.linalg.norm(place - boat.position)
    left = np.array([-ahead[1], ahead[0], 0.0]) / max(math.hypot(ahead[0], ahead[1]), 1e-6)
    sides = sorted(
        (np.cross(ahead, left), left, -left), key=lambda side: -round(float(side @ boat.velocity))
    )
    for angle in DETOURS:
        for side in sides:  # the side it moves to comes first
            tip = boat.position + DETOUR_CM * (math.cos(angle) * ahead + math.sin(angle) * side)
            floor = height_at(sea.floor, sea.half_width, tip[0], tip[1])
            free = floor + HULL_CM < tip[2] < -HULL_CM
            free = free and math.hypot(tip[0], tip[1]) < world.scenario.bounds.radius_cm - HULL_CM
            if free and not hidden(world, vector(tip), vector(boat.position), HULL_CM):
                return np.asarray(tip)
    return place
