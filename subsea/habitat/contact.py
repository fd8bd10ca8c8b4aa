"""Contact of bodies with solids, with the bounds of the sea and with each other, by water drift.

Fishes steer clear of both (`behavior/steering.py`). One that comes too fast to turn, or turns from
one stone into another, slides along what it touches.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import (
    far_from_rock,
    from_pillar,
    from_rock,
    height_at,
    is_far_from_rocks,
    ray_meets_pillar,
    ray_meets_rock,
)
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.habitat.formations import NEAR_CM, blocks_near, drawn_distance, outward
from subsea.kernels import kernel
from subsea.state import APPROACHING, NOBODY, PREDATOR, Fishes, Minds, Sea
from subsea.state.places import place_near

MAX_STEPS = 12  # most steps out of overlapping solids


@kernel
def clearance(pillars: Array, rocks: Array, p: Vector) -> float:
    """Distance of p from the nearest solid (cm, negative inside); infinite without solids."""
    nearest = np.inf
    for k in range(len(pillars)):
        nearest = min(nearest, from_pillar(pillars[k], p)[1])
    for k in range(len(rocks)):
        nearest = min(nearest, from_rock(rocks[k], p)[1])
    return nearest


@kernel
def clearances(pillars: Array, rocks: Array, places: Array) -> Array:
    """Distances (n,) of places (n, 3) from the nearest solid, cm."""
    far = np.empty(len(places))
    for k in range(len(places)):
        far[k] = clearance(pillars, rocks, vector(places[k]))
    return far


@kernel
def stands_between(pillars: Array, rocks: Array, a: Vector, b: Vector, margin: float) -> bool:
    """True if a solid, enlarged by `margin` cm, lies between a and b and does not contain b."""
    met = False
    for k in range(len(pillars)):
        met = met or 0.0 < ray_meets_pillar(pillars[k], margin, b, a) <= 1.0
    for k in range(len(rocks)):
        met = met or 0.0 < ray_meets_rock(rocks[k], margin, b, a) <= 1.0
    return met


@kernel
def is_free(pillars: Array, rocks: Array, p: Vector) -> bool:
    """True if p lies in no solid; cheaper than `clearance`."""
    for k in range(len(pillars)):
        x, y, radius, top = pillars[k]
        if p[2] < top and (p[0] - x) ** 2 + (p[1] - y) ** 2 < radius * radius:
            return False
    for k in range(len(rocks)):
        reach = max(rocks[k, 3], rocks[k, 4])
        near = abs(p[0] - rocks[k, 0]) < reach and abs(p[1] - rocks[k, 1]) < reach
        near = near and abs(p[2] - rocks[k, 2]) < rocks[k, 5]
        if near and from_rock(rocks[k], p)[1] < 0.0:
            return False
    return True


@kernel
def out_of_solids(sea: Sea, p: Vector, room: float, above: float, below: float) -> Vector:
    """A place near p that keeps `room` cm off every solid.

    It is at least `above` cm over the floor and `below` cm under the surface. Returns the last
    place tried if solids stand too close for that.
    """
    for _ in range(MAX_STEPS):
        moved = False
        for k in range(len(sea.pillars)):
            x, y, radius, top = sea.pillars[k]
            if top + room > -below:  # no way over it
                top = np.inf
            way, gap = from_pillar((x, y, radius, top), p)
            if gap < room:
                p, moved = plus(p, times(room - gap + 0.1, way)), True
        for k in range(len(sea.rocks)):
            way, gap = from_rock(sea.rocks[k], p)
            if gap < room:
                ground = height_at(sea.heights, sea.half_width, p[0], p[1])
                roof = sea.rocks[k, 2] - sea.rocks[k, 5]
                if way[2] < 0.0 and roof < ground + above + room:  # aside, not into the ground
                    level = (way[0], way[1], 0.0)
                    way = times(1.0 / max(norm(level), 1e-3), level)
                p, moved = plus(p, times(room - gap + 0.1, way)), True
        floor = height_at(sea.floor, sea.half_width, p[0], p[1])
        height = min(max(p[2], floor + above), -below)
        if height != p[2]:  # which may have brought it to a solid
            p, moved = (p[0], p[1], height), True
        if not moved:
            break
    return p


GAP_BL = 0.12  # gap between skins, over the longer body, where separation begins
FULL_CM_S = 6.0  # speed at which touching bodies are pushed apart
FAR = 1.001  # share of the reach of two bodies beyond which they surely do not touch
CLOSEST = 2  # neighbours considered, besides the threat


@kernel
def separate(who: Ints, fishes: Fishes, minds: Minds) -> None:
    """Add to the drift of the fishes `who` what parts them from bodies that they nearly touch.

    Not for courting partners, nor for predators and their prey. Predators part from their rivals.
    """
    for i in who:
        if not fishes.alive[i] or minds.courtship[i] > APPROACHING:
            continue
        hunts = minds.kind[i] == PREDATOR
        for k in range(1 if hunts else CLOSEST + 1):
            j = minds.neighbour[i, k] if k < CLOSEST else minds.threat[i]
            j = minds.rival[i] if hunts else j
            felt = k == CLOSEST and (j == minds.neighbour[i, 0] or j == minds.neighbour[i, 1])
            if j == NOBODY or felt or not fishes.alive[j] or (minds.kind[j] == PREDATOR) != hunts:
                continue
            longer = max(fishes.length[i], fishes.length[j])
            touching = 0.25 * (
                fishes.girth[i, 0] + fishes.girth[i, 1] + fishes.girth[j, 0] + fishes.girth[j, 1]
            )
            reach = _half(fishes, i) + _half(fishes, j) + touching + GAP_BL * longer
            here = vector(fishes.position[i])
            there = place_near(fishes, j, here)
            apart = minus(here, there)
            if dot(apart, apart) > (FAR * reach) ** 2:
                continue  # most are
            away = _between(fishes, i, j, there)
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
def _between(fishes: Fishes, i: int, j: int, there: Vector) -> Vector:
    """From the nearest point of the straight centre line of j, at `there`, to that of i, cm."""
    a, b = x_axis(fishes.orientation[i]), x_axis(fishes.orientation[j])
    half_a, half_b = 0.5 * float(fishes.length[i]), 0.5 * float(fishes.length[j])
    middle_a = plus(vector(fishes.position[i]), times(float(fishes.snout[i]) - half_a, a))
    middle_b = plus(there, times(float(fishes.snout[j]) - half_b, b))
    gap = minus(middle_a, middle_b)
    # The closest points of two lines, each then held to its body.
    slant, along_a, along_b = dot(a, b), dot(a, gap), dot(b, gap)
    square = max(1.0 - slant * slant, 1e-6)
    s = min(max((slant * along_b - along_a) / square, -half_a), half_a)
    t = min(max(slant * s + along_b, -half_b), half_b)
    s = min(max(slant * t - along_a, -half_a), half_a)
    return minus(plus(gap, times(s, a)), times(t, b))


TOUCH_CM, TOUCH_BL = 3.0, 0.06  # gap of a touching body, with room for its bends
GRAZING_CM = 0.3  # gap of a body that feeds or hides at a surface ...
DRAWN_CM = 1.5  # ... and in the shell around stone, from the drawn stone
OUT_PER_S = 6.0  # outward speed per cm of a gap that is too small, and inward per cm of one more
GENTLE_CM_S = 8.0  # fastest outward speed of a body that is near a barrier, but not beyond it
BRAKES_CM = 20.0  # farthest from the gap that a body keeps at which it brakes
SLOPE_CM = 10.0  # baseline of the slope of the seabed
PASSES = 2  # over the barriers, so that in a corner neither undoes the other


@kernel
def keep_in_free_water(who: Ints, fishes: Fishes, sea: Sea, own: Array, dt: float) -> None:
    """Add to the drift of the fishes `who` what keeps snout, middle and tail in free water.

    `own` (n, 3) is the velocity of each fish through the water, cm/s. A part that would be too
    near after `dt` s is pushed off. Before, it loses its speed toward the barrier the more, the
    nearer it is, so that no fish stops with a jerk. A fish on the hook is not kept under the
    surface.
    """
    for i in who:
        if not fishes.alive[i] or i == sea.catch[1]:
            continue
        middle, length = vector(fishes.position[i]), float(fishes.length[i])
        speed = norm(plus(vector(own[i]), vector(fishes.drift[i])))
        near = Nearness(_touch(fishes, i), min(speed / OUT_PER_S, BRAKES_CM), 2.0 * _room(length))
        reach = length + near.touch + near.brakes + speed * dt
        ahead, snout = x_axis(fishes.orientation[i]), float(fishes.snout[i])
        rim = math.sqrt(middle[0] * middle[0] + middle[1] * middle[1])
        above, below = middle[2] + reach, middle[2] - reach
        inside = rim + reach < sea.radius and above < 0.0 and below > sea.crest
        for _ in range(0 if inside else PASSES):
            for half in range(3):
                part = plus(middle, times(snout - 0.5 * half * length, ahead))
                _keep_inside(fishes.drift[i], part, own[i], sea, near, dt)
        if fishes.shell[i] > 0.0:
            _keep_off_drawn(fishes, i, sea, own[i], dt)
        for k in range(len(sea.pillars)):
            if from_pillar(sea.pillars[k], middle)[1] < reach:
                _keep_off(fishes, i, sea.pillars[k], own[i], near, dt)
        if is_far_from_rocks(sea.tops, sea.half_width, middle, reach):
            continue
        for k in range(len(sea.rocks)):
            if not far_from_rock(sea.rocks[k], middle, reach):
                _keep_off(fishes, i, sea.rocks[k], own[i], near, dt)


class Nearness(NamedTuple):
    """Gaps of a body to barriers, cm."""

    touch: float  # that it keeps
    brakes: float  # more than this, at which it brakes
    deepest: float  # by which a gap may be too small and still count


@kernel
def _room(length: float) -> float:
    """Gap, cm, that a body of `length` cm keeps."""
    return TOUCH_CM + TOUCH_BL * length


@kernel
def _touch(fishes: Fishes, i: int) -> float:
    """Gap, cm, to barriers that fish i keeps: little while it feeds or hides at one."""
    return GRAZING_CM if fishes.close[i] else _room(float(fishes.length[i]))


@kernel
def _keep_inside(
    drift: Array, part: Vector, own: Array, sea: Sea, near: Nearness, dt: float
) -> None:
    """Keep a part of a body within wall, surface and seabed."""
    felt = near.touch + near.brakes
    later = _later(part, own, drift, dt)
    away = math.sqrt(later[0] * later[0] + later[1] * later[1])
    if sea.radius - away < felt:
        inward = (-later[0] / away, -later[1] / away, 0.0)
        now = sea.radius - math.sqrt(part[0] * part[0] + part[1] * part[1])
        _push(drift, inward, now, sea.radius - away, near, dt)
    if -later[2] < felt:
        _push(drift, (0.0, 0.0, -1.0), -part[2], -later[2], near, dt)
    if later[2] - felt < sea.crest:
        floor = height_at(sea.heights, sea.half_width, later[0], later[1])
        if later[2] - floor < felt + near.touch:
            east = height_at(sea.heights, sea.half_width, later[0] + SLOPE_CM, later[1])
            north = height_at(sea.heights, sea.half_width, later[0], later[1] + SLOPE_CM)
            slope = ((floor - east) / SLOPE_CM, (floor - north) / SLOPE_CM, 1.0)
            normal = times(1.0 / norm(slope), slope)
            below = height_at(sea.heights, sea.half_width, part[0], part[1])
            now, gap = (part[2] - below) * normal[2], (later[2] - floor) * normal[2]
            _push(drift, normal, now, gap, near, dt)


@kernel
def _keep_off(fishes: Fishes, i: int, solid: Array, own: Array, near: Nearness, dt: float) -> None:
    """Keep snout, middle and tail of fish i off a pillar (4,) or a rock (7,)."""
    middle, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    snout, length = float(fishes.snout[i]), float(fishes.length[i])
    for half in range(3):
        part = plus(middle, times(snout - 0.5 * half * length, ahead))
        way, gap = _from_solid(solid, _later(part, own, fishes.drift[i], dt))
        shell = float(fishes.shell[i])
        if gap + shell < near.touch + near.brakes:
            now = _from_solid(solid, part)[1] + shell
            _push(fishes.drift[i], way, now, gap + shell, near, dt)


@kernel
def _keep_off_drawn(fishes: Fishes, i: int, sea: Sea, own: Array, dt: float) -> None:
    """Keep snout, middle and tail of fish i, in the shell around stone, off the drawn stone."""
    middle, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    snout, length = float(fishes.snout[i]), float(fishes.length[i])
    for half in range(3):
        part = plus(middle, times(snout - 0.5 * half * length, ahead))
        later = _later(part, own, fishes.drift[i], dt)
        blocks = blocks_near(sea.stones, later, NEAR_CM)
        if len(blocks) == 0:
            continue
        gap = drawn_distance(blocks, later)
        if gap < DRAWN_CM:
            way, slope = outward(blocks, later)
            steep, now = max(slope, 1.0), drawn_distance(blocks, part)
            near = Nearness(DRAWN_CM, 0.0, DRAWN_CM)
            _push(fishes.drift[i], way, now / steep, gap / steep, near, dt)


@kernel
def _later(part: Vector, own: Array, drift: Array, dt: float) -> Vector:
    """The place of a part of a body after `dt` s."""
    return plus(part, times(dt, plus(vector(own), vector(drift))))


@kernel
def _from_solid(solid: Array, p: Vector) -> tuple[Vector, float]:
    """Outward direction at p and distance from a pillar (4,) or a rock (7,)."""
    return from_pillar(solid, p) if len(solid) == 4 else from_rock(solid, p)


@kernel
def _push(drift: Array, way: Vector, now: float, later: float, near: Nearness, dt: float) -> None:
    """Add a drift along `way` for a gap that would change from `now` to `later`, cm, in `dt` s.

    It slows the approach to the gap that a body keeps, and widens one that is too small.
    """
    most = GENTLE_CM_S + OUT_PER_S * min(max(-now, 0.0), near.deepest)
    least = min(OUT_PER_S * (near.touch - now), most)
    speed = max(least - (later - now) / dt, 0.0)
    for axis in range(3):
        drift[axis] += np.float32(speed * way[axis])
