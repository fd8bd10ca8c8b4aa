"""The bow wave of the submarine, which moves the fishes around it."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, times, unit, vector
from subsea.kernels import kernel
from subsea.state import HULL_CM, Fishes, Sea

BEAM_BL = 0.25  # share of a fish's length added to the hull's radius, so that they do not touch
WAVE_SPAN = 4.0  # radii beyond which the wave has less than 2% of the hull's speed


@kernel
def add_bow_wave(who: Ints, fishes: Fishes, sea: Sea) -> None:
    """Add the bow wave to the drift of the fishes `who`: a hull pushes them aside."""
    hull, velocity = vector(sea.submarine[:3]), vector(sea.submarine[3:6])
    if norm(velocity) == 0.0:
        return
    for i in who:
        radius = HULL_CM + BEAM_BL * fishes.length[i]
        if abs(fishes.position[i, 0] - hull[0]) > WAVE_SPAN * radius:
            continue
        wave = bow_wave(minus(vector(fishes.position[i]), hull), velocity, radius)
        for axis in range(3):
            fishes.drift[i, axis] += np.float32(wave[axis])


@kernel
def bow_wave(place: Vector, velocity: Vector, radius: float) -> Vector:
    """Velocity of the water, cm/s, at `place`, cm from the middle of a moving sphere.

    Potential flow about a sphere, a dipole: u = (R/r)³ (3 (v·e) e - v)/2. On the sphere the
    water moves outward as fast as the sphere does, so nothing passes its surface.
    """
    distance = norm(place)
    if distance > WAVE_SPAN * radius or distance < 1e-6:
        return ZERO
    outward = unit(place)
    share = 0.5 * min(radius / distance, 1.0) ** 3
    along = times(3.0 * dot(velocity, outward), outward)
    return times(share, plus(along, times(-1.0, velocity)))
