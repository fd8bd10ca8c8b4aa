"""Constrain urges to free water and turn them into goals of the motor system (SMC §6.2)."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.behavior.chasing import set_urge
from subsea.geometry.angles import arc_tangent, sine_cosine
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import (
    far_from_rock,
    from_pillar,
    from_rock,
    height_at,
    is_far_from_rocks,
)
from subsea.geometry.vector import Vector, dot, minus, norm, plus, store, times, unit, vector
from subsea.kernels import kernel
from subsea.state import (
    BATHE,
    CLEAN,
    EAT,
    ESCAPE,
    GRAZE,
    HULL_CM,
    LEFT,
    MATE,
    POSE,
    PREDATOR,
    RIGHT,
    SHELTER,
    SUBMARINE,
    Clock,
    Fishes,
    Minds,
    Sea,
)
from subsea.state.habits import keeps_low

EASE = 4.0  # 1/s: how fast a goal follows an urge, so that no fish twitches
ROOM_BL, ROOM_S = 2.0, 1.0  # room to turn away: lengths at rest, and s of its motion
BODY_BL = 0.45  # farthest part of a body from its middle
BOLD = 0.4  # share of that room for a hunter, which follows its prey between stones, ...
# ... and for a fish that keeps to the ground or lives on stone, which is among it all the time.
CLEARANCE_CM, CLEARANCE_BL = 8.0, 0.2  # free water beyond snout and tail
CORNERED = 0.1  # part of a unit urge; in a corner a solid turns more toward the wall
WINDOW_COS = np.cos(np.radians(28.0))  # half the angle of the window
HULL_AHEAD_S = 1.5  # how far ahead the submarine's motion is predicted
STEEPEST = np.sin(np.radians(20.0))  # steepest urge, except of the intentions STEEP
STEEP = (ESCAPE, EAT, MATE, GRAZE, BATHE, SHELTER, POSE, CLEAN)
LEAVES_CM_S = 12.5  # how fast a fish that has fed leaves the shell of free water around stone
SLOPE_CM = 20.0  # baseline of the seabed's slope


@kernel
def keep_clear(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> None:
    """Turn `minds.urge` of the fishes `who` away from the bounds of the sea and from solids.

    Near a boundary the urge is constrained (SMC §6.2): the nearer snout or tail, the less it may
    point outward, and too near it must point inward. The rest runs along the boundary.
    """
    hull, velocity = vector(sea.submarine[:3]), vector(sea.submarine[3:6])
    rocks = np.empty(len(sea.rocks), np.int64)
    for i in who:
        here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
        urge = vector(minds.urge[i])
        size, length = norm(urge), float(fishes.length[i])
        urge = times(1.0 / size, urge) if size >= 1e-9 else ahead
        if minds.intention[i] not in STEEP:
            urge = flattened(urge, STEEPEST)
        # A cleaner before the window keeps off by itself.
        at_glass = minds.intention[i] == CLEAN and minds.client[i] == SUBMARINE
        at_glass = at_glass and is_before_window(here, sea)
        if fishes.close[i]:  # contact alone keeps it out of what it feeds on or hides in
            set_urge(minds, i, _off_the_hull(here, length, hull, velocity, urge))
            continue
        snout = plus(here, times(float(fishes.snout[i]), ahead))
        tail = plus(snout, times(-length, ahead))
        reach = CLEARANCE_CM + CLEARANCE_BL * length
        # Large fishes turn more slowly, and fast ones on a wider circle.
        room = ROOM_BL * length + ROOM_S * norm(vector(fishes.velocity[i])) / fishes.rate[i]
        hunts = minds.kind[i] == PREDATOR and minds.intention[i] == EAT
        if hunts or keeps_low(minds, i):
            room *= BOLD
        farthest = norm(minus(snout, here)) + length
        near = rocks[: _rocks_near(here, reach + room + farthest, sea, rocks)]
        # Twice, so that in a corner neither undoes the other.
        for _ in range(2):
            for part in (tail, snout):
                urge = _inside(part, reach, room, sea, urge)
                urge = _around(part, reach, room, sea, near, urge)
            if not at_glass:
                urge = _off_the_hull(here, length, hull, velocity, urge)
        for part in (tail, snout):
            urge = _out_of_corner(part, reach, room, sea, near, urge)
        set_urge(minds, i, urge)


@kernel
def flattened(urge: Vector, steepest: float) -> Vector:
    """A unit urge that climbs or dives by at most the sine `steepest`, on the same bearing.

    A vertical urge has no bearing and stays.
    """
    level = np.sqrt(urge[0] * urge[0] + urge[1] * urge[1])
    if abs(urge[2]) <= steepest or level < 1e-6:
        return urge
    share = np.sqrt(1.0 - steepest * steepest) / level
    return share * urge[0], share * urge[1], steepest if urge[2] > 0.0 else -steepest


@kernel
def _inside(p: Vector, reach: float, room: float, sea: Sea, urge: Vector) -> Vector:
    """The urge constrained by wall, surface and floor near a part of the body at p.

    It keeps `reach` cm off, and turns away within `room` cm more.
    """
    away = max(np.sqrt(p[0] * p[0] + p[1] * p[1]), 1e-6)
    if sea.radius - away < reach + room:
        inward = (-p[0] / away, -p[1] / away, 0.0)
        urge = constrained(urge, inward, sea.radius - away - reach, room)
    urge = constrained(urge, (0.0, 0.0, -1.0), -p[2] - reach, room)
    floor = height_at(sea.floor, sea.half_width, p[0], p[1])
    if p[2] - floor < 1.5 * (reach + room):
        east = height_at(sea.floor, sea.half_width, p[0] + SLOPE_CM, p[1])
        north = height_at(sea.floor, sea.half_width, p[0], p[1] + SLOPE_CM)
        normal = unit(((floor - east) / SLOPE_CM, (floor - north) / SLOPE_CM, 1.0))
        urge = constrained(urge, normal, (p[2] - floor) * normal[2] - reach, room)
    return urge


@kernel
def _rocks_near(p: Vector, reach: float, sea: Sea, rocks: Ints) -> int:
    """Write the numbers of the rocks within `reach` cm of p, and others, to `rocks`; how many."""
    if is_far_from_rocks(sea.tops, sea.half_width, p, reach):
        return 0
    count = 0
    for k in range(len(sea.rocks)):
        rocks[count] = k
        count += not far_from_rock(sea.rocks[k], p, reach)
    return count


@kernel
def _around(p: Vector, reach: float, room: float, sea: Sea, rocks: Ints, urge: Vector) -> Vector:
    """The urge constrained by pillars and by the `rocks` near a part of the body at p."""
    for k in range(len(sea.pillars)):
        normal, distance = from_pillar(sea.pillars[k], p)
        if distance < reach + room:
            urge = constrained(urge, normal, distance - reach, room)
    for k in rocks:
        if far_from_rock(sea.rocks[k], p, reach + room):
            continue
        normal, distance = from_rock(sea.rocks[k], p)
        if distance < reach + room:
            urge = constrained(urge, normal, distance - reach, room)
    return urge


@kernel
def _out_of_corner(
    p: Vector, reach: float, room: float, sea: Sea, rocks: Ints, urge: Vector
) -> Vector:
    """The urge back from a corner of the wall and a solid, or as it is elsewhere.

    There each barrier turns the urge along itself, into the other one.
    """
    away = max(np.sqrt(p[0] * p[0] + p[1] * p[1]), 1e-6)
    gap = sea.radius - away - reach
    inward = (-p[0] / away, -p[1] / away, 0.0)
    if dot(urge, inward) >= -max(gap / room, 0.0) - CORNERED:
        return urge
    return _around(p, reach, room, sea, rocks, inward)


@kernel
def is_before_window(here: Vector, sea: Sea) -> bool:
    """True if a place is ahead of the submarine, within the angle of its window."""
    away = minus(here, vector(sea.submarine[:3]))
    return bool(dot(away, vector(sea.submarine[6:9])) > WINDOW_COS * norm(away))


@kernel
def _off_the_hull(
    here: Vector, length: float, hull: Vector, velocity: Vector, urge: Vector
) -> Vector:
    """The urge constrained by the submarine at its predicted closest approach."""
    away = minus(here, hull)
    reach, room = HULL_CM + BODY_BL * length + CLEARANCE_CM, ROOM_BL * length
    speed = norm(velocity)
    if norm(away) > reach + room + HULL_AHEAD_S * speed:
        return urge
    if speed > 1.0:
        until = min(max(dot(away, velocity) / speed**2, 0.0), HULL_AHEAD_S)
        away = minus(away, times(until, velocity))
    distance = norm(away)
    if distance >= reach + room:
        return urge
    normal = (0.0, 0.0, 1.0) if distance < 1.0 else times(1.0 / distance, away)
    return constrained(urge, normal, distance - reach, room)


@kernel
def constrained(urge: Vector, normal: Vector, distance: float, room: float) -> Vector:
    """A unit urge that heads for a boundary no harder than `distance` over `room` allows.

    `normal` points away from the boundary. At distance zero the urge runs along the boundary,
    and behind it leads back.
    """
    least = -min(max(distance / room, -1.0), 1.0)
    inward = dot(urge, normal)
    if inward >= least:
        return urge
    along = minus(urge, times(inward, normal))
    size = norm(along)
    if size < 1e-3:
        # Head-on: along the boundary to the left.
        along = (-normal[1], normal[0], 0.0) if abs(normal[2]) < 0.9 else (1.0, 0.0, 0.0)
        size = norm(along)
    return plus(times(least, normal), times(np.sqrt(1.0 - least * least) / size, along))


@kernel
def ease_goals(who: Ints, fishes: Fishes, minds: Minds, clock: Clock) -> None:
    """Turn the goals of the fishes `who` toward their urges by a share of the angle.

    A fish that has left its place at stone loses its leave to be in the shell around it.

    Where the motor preferences warn of a side, the angle is multiplied by min(1, 1.5 + M) for the
    negative preference M (Tu §6.5.3).
    """
    share = min(EASE * clock.dt, 1.0)
    for i in who:
        if not fishes.close[i] and fishes.shell[i] > 0.0:
            left = max(float(fishes.shell[i]) - LEAVES_CM_S * clock.dt, 0.0)
            fishes.shell[i] = np.float32(left)
        urge = vector(minds.urge[i])
        length = norm(urge)
        if length < 1e-6:
            continue
        now = vector(fishes.goal_direction[i])
        along = dot(now, urge) / length
        across = minus(times(1.0 / length, urge), times(along, now))
        sine = norm(across)
        if sine < 1e-4:
            if along > 0.0:
                continue
            # Straight behind: turn left.
            across = unit((1e-6 - now[1], now[0], 0.0))
        else:
            across = times(1.0 / sine, across)
        left = now[0] * urge[1] - now[1] * urge[0] > 0.0
        warning = float(minds.preference[i, LEFT if left else RIGHT])
        angle = share * min(1.0, 1.5 + warning) * arc_tangent(sine, along)
        aside, ahead = sine_cosine(angle)
        wish = unit(plus(times(ahead, now), times(aside, across)))
        store(fishes.goal_direction[i], wish)
