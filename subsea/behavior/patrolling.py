"""The calm swimming of predators: patrol, circle out after a miss, give way to larger ones."""

import numpy as np

from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, unit, vector
from subsea.kernels import kernel
from subsea.state import HUNGER, NOBODY, PATROLLING, RECOVERING, Fishes, Minds
from subsea.state.places import place_near

PATROL_BL_S = 0.34, 0.56  # speed, by identity: reef sharks cruise at 0.3 to 0.6 L/s
SHARES = 0.1, 0.7  # of the fastest speed: least and greatest on patrol
OUT_RAD = np.radians(50.0)  # how far ahead of its heading a hunter turns that circles out
SINKS = 0.12  # slope at which it goes down then
SHADOW_BL = 3.0  # distance of prey beyond which a hunter on patrol turns back to it ...
SHADOWS = 1.5  # ... with this weight, times its hunger
PERSONAL_BL = 1.6  # distance that predators keep, mean lengths of both
YIELDS, INSISTS = 2.5, 0.6  # weights of turning away from a larger and from a smaller one
SLOWED = 0.36  # share of the fastest speed behind a larger one


@kernel
def patrol_speed(fishes: Fishes, i: int) -> float:
    """The share of its fastest speed at which fish i patrols."""
    low, high = PATROL_BL_S
    speed = (low + (high - low) * float(fishes.identity[i])) * float(fishes.length[i])
    return min(max(speed / max(float(fishes.fast[i]), 1e-6), SHARES[0]), SHARES[1])


@kernel
def patrol(fishes: Fishes, minds: Minds, i: int, way: Vector) -> Vector:
    """The direction of predator i on patrol that heads along `way`, a unit vector.

    It shadows the prey that it will stalk, the hungrier the more, unless it is on an errand. After
    a miss it circles out instead, by turns to the left and to the right.
    """
    j = minds.foods[i, 0]
    if minds.hunt[i] == RECOVERING:
        ahead = x_axis(fishes.orientation[i])
        side = 1.0 if (i + int(minds.misses[i])) % 2 == 0 else -1.0
        c, s = np.cos(OUT_RAD), side * np.sin(OUT_RAD)
        way = (c * ahead[0] - s * ahead[1], s * ahead[0] + c * ahead[1], -SINKS)
    elif minds.hunt[i] == PATROLLING and j >= 0 and minds.errand[i] <= 0.0:
        here = vector(fishes.position[i])
        toward = minus(place_near(fishes, j, here), here)
        distance = norm(toward)
        if distance > SHADOW_BL * fishes.length[i]:
            way = plus(way, times(SHADOWS * float(minds.mental[i, HUNGER]) / distance, toward))
    return give_way(fishes, minds, i, way)


@kernel
def give_way(fishes: Fishes, minds: Minds, i: int, way: Vector) -> Vector:
    """Turn a direction away from a rival that is too near, more if that one is larger."""
    j = minds.rival[i]
    if j == NOBODY or not fishes.alive[j]:
        return way
    here = vector(fishes.position[i])
    away = minus(here, place_near(fishes, j, here))
    distance = norm(away)
    reach = PERSONAL_BL * 0.5 * (fishes.length[i] + fishes.length[j])
    if distance >= reach or distance < 1e-6:
        return way
    weight = YIELDS if yields(fishes, i, j) else INSISTS
    share = weight * (1.0 - distance / reach) / distance
    return plus(unit(way), times(share, away))


@kernel
def yields(fishes: Fishes, i: int, j: int) -> bool:
    """True if predator i gives way to predator j: to a larger one, of equal ones to the first."""
    if fishes.length[i] != fishes.length[j]:
        return bool(fishes.length[i] < fishes.length[j])
    return j < i


@kernel
def is_blocked(fishes: Fishes, minds: Minds, i: int) -> bool:
    """True if a rival to which predator i gives way is close before it."""
    j = minds.rival[i]
    if j == NOBODY or not fishes.alive[j] or not yields(fishes, i, j):
        return False
    here = vector(fishes.position[i])
    toward = minus(place_near(fishes, j, here), here)
    near = norm(toward) < 0.5 * PERSONAL_BL * (fishes.length[i] + fishes.length[j])
    return near and dot(toward, x_axis(fishes.orientation[i])) > 0.0
