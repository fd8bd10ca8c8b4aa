"""What a fish may do, each as a direction and a weight: wandering, schooling, keeping clear.

Every routine is a compiled function of one fish. It returns a vector whose direction is where
to swim and whose length is how much that matters.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.heightfield import height_at
from subsea.kinematics.keyed import uniform
from subsea.kinematics.vector import ZERO, Vector, minus, norm, plus, times, vector
from subsea.state import Fishes

Array = NDArray[np.floating[Any]]

ROAM = 0.8  # share of the world's radius in which waypoints lie
SLOPE = 0.3  # of the way to a waypoint
ARRIVED_BL = 3.0  # a waypoint counts as reached within this many body lengths
PATIENCE_S = (9.0, 24.0)  # how long a fish keeps a waypoint that it doesn't reach
MARGIN_CM = 170.0  # from the wall inward, where turning away begins
FLOOR_CM = 75.0  # above the seabed
SURFACE_CM = 80.0  # below the surface
SPACING_BL = 1.0  # schooling fishes keep one body length apart (Tu §7.9.2)
FOLLOW_BL = 5.0  # a follower farther than this from its leader catches up
STARTLE_CM = 150.0  # a fish gives way to the submarine inside this distance
ANGLE_PURPOSE, RADIUS_PURPOSE, DEPTH_PURPOSE, PATIENCE_PURPOSE = range(4)


@njit(cache=True)
def wander(
    fishes: Fishes,
    i: int,
    heights: Array,
    half_width: float,
    radius: float,
    seed: int,
    tick: int,
    dt: float,
) -> Vector:
    """Toward a waypoint that is drawn anew when it is reached or has been pursued too long."""
    fishes.patience[i] -= np.float32(dt)
    here = vector(fishes.position[i])
    toward = minus(vector(fishes.waypoint[i]), here)
    distance = norm(toward)
    if fishes.patience[i] <= 0.0 or distance < ARRIVED_BL * fishes.length[i]:
        angle = 2.0 * np.pi * uniform(seed, i, tick, ANGLE_PURPOSE)
        reach = ROAM * radius * np.sqrt(uniform(seed, i, tick, RADIUS_PURPOSE))
        x, y = reach * np.cos(angle), reach * np.sin(angle)
        floor = height_at(heights, half_width, x, y) + FLOOR_CM
        # Most of a reef's life is in the lower half of the water.
        depth = uniform(seed, i, tick, DEPTH_PURPOSE) ** 1.6
        fishes.waypoint[i, 0] = x
        fishes.waypoint[i, 1] = y
        # It lies at most a gentle climb or dive away.
        rise = SLOPE * np.sqrt((x - here[0]) ** 2 + (y - here[1]) ** 2)
        z = min(max(floor + depth * (-SURFACE_CM - floor), here[2] - rise), here[2] + rise)
        fishes.waypoint[i, 2] = max(z, floor)
        low, high = PATIENCE_S
        share = uniform(seed, i, tick, PATIENCE_PURPOSE)
        fishes.patience[i] = low + (high - low) * share
        toward = minus(vector(fishes.waypoint[i]), here)
        distance = norm(toward)
    return times(1.0 / max(distance, 1.0), toward)


@njit(cache=True)
def follow(fishes: Fishes, i: int) -> Vector:
    """Toward the leader, more the farther it is, and along with it when near."""
    leader = fishes.leader[i]
    toward = minus(vector(fishes.position[leader]), vector(fishes.position[i]))
    distance = norm(toward)
    lag = distance / (FOLLOW_BL * fishes.length[i])
    pull = min(lag * lag, 2.5) / max(distance, 1.0)
    return plus(times(pull, toward), vector(fishes.goal_direction[leader]))


@njit(cache=True)
def keep_company(fishes: Fishes, i: int) -> Vector:
    """Heading like the neighbours, and one body length away from each of them."""
    out, ahead = ZERO, ZERO
    here = vector(fishes.position[i])
    count = 0
    for j in fishes.neighbour[i]:
        if j < 0:
            break
        away = minus(here, vector(fishes.position[j]))
        distance = norm(away)
        space = SPACING_BL * 0.5 * (fishes.length[i] + fishes.length[j])
        if distance < 1.5 * space:
            crowd = 1.5 - distance / space
            out = plus(out, times(1.8 * crowd / max(distance, 0.1), away))
        velocity = vector(fishes.velocity[j])
        ahead = plus(ahead, times(1.0 / max(norm(velocity), 1.0), velocity))
        count += 1
    return plus(out, times(0.7 / max(count, 1), ahead))


@njit(cache=True)
def stay_inside(fishes: Fishes, i: int, heights: Array, half_width: float, radius: float) -> Vector:
    """Away from wall, seabed and surface, harder the nearer and the more it heads there.

    The seabed is felt where the fish is and where it will be in two seconds.
    """
    aside, up = 0.0, 0.0
    p, v = vector(fishes.position[i]), vector(fishes.velocity[i])
    r = np.sqrt(p[0] * p[0] + p[1] * p[1])
    if r > radius - MARGIN_CM:
        near = (r - radius + MARGIN_CM) / MARGIN_CM
        outward = (v[0] * p[0] + v[1] * p[1]) / max(r, 1.0)
        push = 2.5 * near * (1.0 if outward > 0.0 else 0.4) + 4.0 * max(near - 0.7, 0.0)
        aside = -push / r
    floor = height_at(heights, half_width, p[0], p[1])
    later = height_at(heights, half_width, p[0] + 2.0 * v[0], p[1] + 2.0 * v[1])
    room = p[2] - max(floor, later)
    if room < FLOOR_CM:
        up += 2.0 * (1.0 - room / FLOOR_CM)
    if -p[2] < SURFACE_CM:
        up -= 2.0 * (1.0 + p[2] / SURFACE_CM)
    return aside * p[0], aside * p[1], up


@njit(cache=True)
def give_way(fishes: Fishes, i: int, submarine: Array) -> Vector:
    """Away from the submarine when it comes too near."""
    away = minus(vector(fishes.position[i]), vector(submarine))
    distance = norm(away)
    if distance > STARTLE_CM:
        return ZERO
    push = 3.0 * (1.0 - distance / STARTLE_CM) / max(distance, 1.0)
    return push * away[0], push * away[1], 0.5 * push * away[2]
