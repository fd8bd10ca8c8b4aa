"""Separation of bodies from each other, from solids and from the rim, by water drift."""

import math

import numpy as np

from subsea.core.arrays import Array
from subsea.core.kernels import kernel
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import far_from_rock, from_pillar, from_rock
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.state import APPROACHING, NOBODY, PREDATOR, Fishes, Minds, Sea

GAP_BL = 0.12  # gap between skins, over the longer body, where separation begins
FULL_CM_S = 6.0  # speed at which touching bodies are pushed apart
STONE_CM, STONE_PER_S = 4.0, 6.0  # range, and outward speed per cm within it
RIM_CM, RIM_PER_S = 12.0, 8.0  # the same at the rim of the sea
CLOSEST = 2  # neighbours considered, besides the threat


@kernel
def separate(fishes: Fishes, minds: Minds) -> None:
    """Add to `fishes.drift` what separates bodies that are about to touch.

    Not for courting partners, nor for predators and their prey.
    """
    for i in range(len(fishes.length)):
        if not fishes.alive[i] or minds.courtship[i] > APPROACHING or minds.kind[i] == PREDATOR:
            continue
        for k in range(CLOSEST + 1):
            j = minds.neighbour[i, k] if k < CLOSEST else minds.threat[i]
            felt = k == CLOSEST and (j == minds.neighbour[i, 0] or j == minds.neighbour[i, 1])
            if j == NOBODY or felt or not fishes.alive[j] or minds.kind[j] == PREDATOR:
                continue
            away = _between(fishes.position, fishes.orientation, fishes.snout, fishes.length, i, j)
            distance = norm(away)
            longer = max(fishes.length[i], fishes.length[j])
            touching = 0.25 * (
                fishes.girth[i, 0] + fishes.girth[i, 1] + fishes.girth[j, 0] + fishes.girth[j, 1]
            )
            close = 1.0 - (distance - touching) / (GAP_BL * longer)
            if close > 0.0 and distance > 1e-6:
                speed = FULL_CM_S * min(close, 1.0) / distance
                for axis in range(3):
                    fishes.drift[i, axis] += np.float32(speed * away[axis])


@kernel
def keep_off_solids(fishes: Fishes, sea: Sea) -> None:
    """Add to `fishes.drift` what keeps bodies off solids and within the rim.

    Between two stones a fish may turn from one into the other, and a fleeing fish may reach the
    rim too fast to turn.
    """
    for i in range(len(fishes.length)):
        middle, length = vector(fishes.position[i]), float(fishes.length[i])
        away = max(math.sqrt(middle[0] * middle[0] + middle[1] * middle[1]), 1e-6)
        if away > sea.radius - RIM_CM:
            inward = (-middle[0] / away, -middle[1] / away, 0.0)
            _push(fishes.drift[i], inward, sea.radius - away, RIM_CM, RIM_PER_S)
        for k in range(len(sea.pillars)):
            if from_pillar(sea.pillars[k], middle)[1] < STONE_CM + length:
                _keep_off(fishes, i, sea.pillars[k])
        for k in range(len(sea.rocks)):
            if not far_from_rock(sea.rocks[k], middle, STONE_CM + length):
                _keep_off(fishes, i, sea.rocks[k])


@kernel
def _keep_off(fishes: Fishes, i: int, solid: Array) -> None:
    """Push fish i, by its nearest part, away from a pillar (4,) or a rock (7,)."""
    middle, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    snout, length = float(fishes.snout[i]), float(fishes.length[i])
    way, gap = _from_solid(solid, middle)
    for half in range(3):
        place = plus(middle, times(snout - 0.5 * half * length, ahead))
        other, near = _from_solid(solid, place)
        if near < gap:
            way, gap = other, near
    _push(fishes.drift[i], way, gap, STONE_CM, STONE_PER_S)


@kernel
def _from_solid(solid: Array, p: Vector) -> tuple[Vector, float]:
    """Outward direction at p and distance from a pillar (4,) or a rock (7,)."""
    return from_pillar(solid, p) if len(solid) == 4 else from_rock(solid, p)


@kernel
def _push(drift: Array, way: Vector, gap: float, reach: float, rate: float) -> None:
    """Add a drift along `way`, `gap` cm from a solid: `rate` cm/s per cm within `reach`."""
    if gap < reach:
        speed = rate * (reach - gap)
        for axis in range(3):
            drift[axis] += np.float32(speed * way[axis])


@kernel
def _between(
    position: Array, orientation: Array, snout: Array, length: Array, i: int, j: int
) -> Vector:
    """From the nearest point of the straight centre line of j to that of i, cm."""
    a, b = x_axis(orientation[i]), x_axis(orientation[j])
    half_a, half_b = 0.5 * float(length[i]), 0.5 * float(length[j])
    middle_a = plus(vector(position[i]), times(float(snout[i]) - half_a, a))
    middle_b = plus(vector(position[j]), times(float(snout[j]) - half_b, b))
    gap = minus(middle_a, middle_b)
    # The closest points of two lines, each then held to its body.
    slant, along_a, along_b = dot(a, b), dot(a, gap), dot(b, gap)
    square = max(1.0 - slant * slant, 1e-6)
    s = min(max((slant * along_b - along_a) / square, -half_a), half_a)
    t = min(max(slant * s + along_b, -half_b), half_b)
    s = min(max(slant * t - along_a, -half_a), half_a)
    return minus(plus(gap, times(s, a)), times(t, b))
