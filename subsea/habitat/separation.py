"""Separation of bodies from each other, by water drift."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import APPROACHING, NOBODY, PREDATOR, Fishes, Minds

GAP_BL = 0.12  # gap between skins, over the longer body, where separation begins
FULL_CM_S = 6.0  # speed at which touching bodies are pushed apart
FAR = 1.001  # share of the reach of two bodies beyond which they surely do not touch
CLOSEST = 2  # neighbours considered, besides the threat


@kernel
def separate(who: Ints, fishes: Fishes, minds: Minds) -> None:
    """Add to the drift of the fishes `who` what parts them from bodies that they nearly touch.

    Not for courting partners, nor for predators and their prey.
    """
    for i in who:
        if not fishes.alive[i] or minds.courtship[i] > APPROACHING or minds.kind[i] == PREDATOR:
            continue
        for k in range(CLOSEST + 1):
            j = minds.neighbour[i, k] if k < CLOSEST else minds.threat[i]
            felt = k == CLOSEST and (j == minds.neighbour[i, 0] or j == minds.neighbour[i, 1])
            if j == NOBODY or felt or not fishes.alive[j] or minds.kind[j] == PREDATOR:
                continue
            longer = max(fishes.length[i], fishes.length[j])
            touching = 0.25 * (
                fishes.girth[i, 0] + fishes.girth[i, 1] + fishes.girth[j, 0] + fishes.girth[j, 1]
            )
            reach = _half(fishes, i) + _half(fishes, j) + touching + GAP_BL * longer
            apart = minus(vector(fishes.position[i]), vector(fishes.position[j]))
            if dot(apart, apart) > (FAR * reach) ** 2:
                continue  # most are
            away = _between(fishes.position, fishes.orientation, fishes.snout, fishes.length, i, j)
            distance = norm(away)
            close = 1.0 - (distance - touching) / (GAP_BL * longer)
            if close > 0.0 and distance > 1e-6:
                speed = FULL_CM_S * min(close, 1.0) / distance
                for axis in range(3):
                    fishes.drift[i, axis] += np.float32(speed * away[axis])


@kernel
def _half(fishes: Fishes, i: int) -> float:
    """Distance of the farther end of the centre line from the origin of fish i, cm."""
    snout = float(fishes.snout[i])
    return max(abs(snout), abs(snout - float(fishes.length[i])))


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
