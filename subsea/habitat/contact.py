"""Contact of bodies with solids and with the bounds of the sea, by water drift.

Fishes steer clear of both (`behavior/steering.py`). One that comes too fast to turn, or turns from
one stone into another, slides along what it touches.
"""

import math

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.height_field import height_at
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import far_from_rock, from_pillar, from_rock
from subsea.geometry.vector import Vector, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import Fishes, Sea

TOUCH_CM, TOUCH_BL = 3.0, 0.06  # gap of a touching body, with room for its bends
OUT_PER_S = 6.0  # outward speed per cm of a gap that is too small
SLOPE_CM = 10.0  # baseline of the slope of the seabed
PASSES = 2  # over the barriers, so that in a corner neither undoes the other


@kernel
def keep_in_free_water(who: Ints, fishes: Fishes, sea: Sea, own: Array, dt: float) -> None:
    """Add to the drift of the fishes `who` what keeps snout, middle and tail in free water.

    `own` (n, 3) is the velocity of each fish through the water, cm/s. A part that would be too
    near after `dt` s loses its speed toward the barrier and is pushed off. A fish on the hook is
    not kept under the surface.
    """
    for i in who:
        if not fishes.alive[i] or i == sea.catch[1]:
            continue
        middle, length = vector(fishes.position[i]), float(fishes.length[i])
        speed = norm(plus(vector(own[i]), vector(fishes.drift[i])))
        touch = TOUCH_CM + TOUCH_BL * length
        reach = length + touch + speed * dt
        ahead, snout = x_axis(fishes.orientation[i]), float(fishes.snout[i])
        rim = math.sqrt(middle[0] * middle[0] + middle[1] * middle[1])
        above, below = middle[2] + reach, middle[2] - reach
        inside = rim + reach < sea.radius and above < 0.0 and below > sea.crest
        for _ in range(0 if inside else PASSES):
            for half in range(3):
                part = plus(middle, times(snout - 0.5 * half * length, ahead))
                _keep_inside(fishes.drift[i], part, own[i], sea, touch, dt)
        for k in range(len(sea.pillars)):
            if from_pillar(sea.pillars[k], middle)[1] < reach:
                _keep_off(fishes, i, sea.pillars[k], own[i], dt)
        for k in range(len(sea.rocks)):
            if not far_from_rock(sea.rocks[k], middle, reach):
                _keep_off(fishes, i, sea.rocks[k], own[i], dt)


@kernel
def _keep_inside(drift: Array, part: Vector, own: Array, sea: Sea, touch: float, dt: float) -> None:
    """Keep a part of a body within wall, surface and seabed."""
    later = _later(part, own, drift, dt)
    away = math.sqrt(later[0] * later[0] + later[1] * later[1])
    if sea.radius - away < touch:
        inward = (-later[0] / away, -later[1] / away, 0.0)
        now = sea.radius - math.sqrt(part[0] * part[0] + part[1] * part[1])
        _push(drift, inward, now, sea.radius - away, touch, dt)
    if -later[2] < touch:
        _push(drift, (0.0, 0.0, -1.0), -part[2], -later[2], touch, dt)
    if later[2] - touch < sea.crest:
        floor = height_at(sea.heights, sea.half_width, later[0], later[1])
        if later[2] - floor < 2.0 * touch:
            east = height_at(sea.heights, sea.half_width, later[0] + SLOPE_CM, later[1])
            north = height_at(sea.heights, sea.half_width, later[0], later[1] + SLOPE_CM)
            slope = ((floor - east) / SLOPE_CM, (floor - north) / SLOPE_CM, 1.0)
            normal = times(1.0 / norm(slope), slope)
            below = height_at(sea.heights, sea.half_width, part[0], part[1])
            now, gap = (part[2] - below) * normal[2], (later[2] - floor) * normal[2]
            _push(drift, normal, now, gap, touch, dt)


@kernel
def _keep_off(fishes: Fishes, i: int, solid: Array, own: Array, dt: float) -> None:
    """Keep snout, middle and tail of fish i off a pillar (4,) or a rock (7,)."""
    middle, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    snout, length = float(fishes.snout[i]), float(fishes.length[i])
    for half in range(3):
        part = plus(middle, times(snout - 0.5 * half * length, ahead))
        way, gap = _from_solid(solid, _later(part, own, fishes.drift[i], dt))
        touch = TOUCH_CM + TOUCH_BL * length
        if gap < touch:
            _push(fishes.drift[i], way, _from_solid(solid, part)[1], gap, touch, dt)


@kernel
def _later(part: Vector, own: Array, drift: Array, dt: float) -> Vector:
    """The place of a part of a body after `dt` s."""
    return plus(part, times(dt, plus(vector(own), vector(drift))))


@kernel
def _from_solid(solid: Array, p: Vector) -> tuple[Vector, float]:
    """Outward direction at p and distance from a pillar (4,) or a rock (7,)."""
    return from_pillar(solid, p) if len(solid) == 4 else from_rock(solid, p)


@kernel
def _push(drift: Array, way: Vector, now: float, later: float, touch: float, dt: float) -> None:
    """Add a drift along `way` for a gap that would change from `now` to `later`, cm, in `dt` s.

    It takes away the approach within `touch` cm, and widens a gap that is too small.
    """
    outward = OUT_PER_S * max(touch - max(now, -touch), 0.0)
    speed = max(min(outward - (later - now) / dt, (touch - later) / dt), 0.0)
    for axis in range(3):
        drift[axis] += np.float32(speed * way[axis])
