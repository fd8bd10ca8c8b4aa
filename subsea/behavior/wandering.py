"""Wander from waypoint to waypoint when nothing else is desired (Tu §7.8)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.leading import leaves_behind
from subsea.behavior.patrolling import SLOWED as BLOCKED
from subsea.behavior.patrolling import is_blocked, patrol, patrol_speed
from subsea.behavior.tracking import PACE, is_on_trail, track
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import (
    from_pillar,
    from_rock,
    height_at,
    ray_meets_pillar,
    ray_meets_rock,
)
from subsea.geometry.vector import Vector, dot, minus, norm, store, times, vector
from subsea.kernels import kernel
from subsea.state import PREDATOR, Clock, Fishes, Minds, Nature, Sea

ROAM = 0.8  # share of the sea's radius within which waypoints lie
SLOPE = 0.3  # steepest way to a waypoint
ARRIVED_BL = 3.0  # distance at which a waypoint is reached
PATIENCE_S = (2.0, 12.0)  # how long a fish heads for a waypoint, beyond the time for the way ...
SLOWEST = 0.3  # ... at this share of its fastest speed
FLOOR_CM = 75.0  # height of waypoints above the floor ...
LOW = 0.35  # of that depth for predators, which patrol below their prey
SURFACE_CM = 80.0  # ... their depth ...
FREE_CM = 40.0  # ... and their distance from solids, ...
ATTEMPTS = 6  # ... within this many attempts
LEADERS_ATTEMPTS = 24  # for a leader, whose waypoint must also ...
AHEAD_COS = -0.2  # ... not be behind it, and be ...
BROAD_CM = 100.0  # ... this far from solids, which split a school
HOME_SHARE = 0.7  # of its range within which a fish with a home wanders ...
HOME_FLOOR_CM = 12.0  # ... at least this high
CRUISE = (0.1, 0.62, 0.85)  # shares of the fastest speed: hovering, medium and brisk cruising
LEADING = 0.45  # a leader keeps its school moving
TRACKS = 0.6  # desire of a fish that follows an odour
BOUND = 0.7  # desire of a fish on an errand: stronger than curiosity
WAITING = 0.2  # its speed while no companion is near, or many are left behind
ANGLE_PURPOSE, RADIUS_PURPOSE, DEPTH_PURPOSE, PATIENCE_PURPOSE = (np.int64(key) for key in range(4))


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """A small constant desire; strong while the fish follows an odour, strongest on an errand.

    In the company of its school a fish goes on the errand with it.
    """
    for i in who:
        schools = minds.leads[i] and not minds.led[i] and minds.neighbour[i, 0] >= 0
        out[i] = TRACKS if is_on_trail(minds, i) else 0.01
        if minds.errand[i] > 0.0 and not schools:
            out[i] = BOUND


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Swim to the waypoint at a cruising speed."""
    for i in who:
        wander(fishes, minds, i, sea, clock)
        alone = minds.neighbour[i, 0] < 0
        if minds.leads[i] and (alone or leaves_behind(fishes, minds, i, clock.tick * clock.dt)):
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(WAITING))


@kernel
def wander(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> None:
    """Let fish i swim to its waypoint, or along an odour, at its cruising speed."""
    way = heading(fishes, minds, i, sea, clock)
    fishes.goal_speed[i] = cruise(fishes, minds, i)
    if minds.errand[i] <= 0.0 and minds.scavenges[i]:
        way, tracks = track(fishes, minds, i, way)
        fishes.goal_speed[i] = max(fishes.goal_speed[i], PACE) if tracks else fishes.goal_speed[i]
    if minds.kind[i] == PREDATOR:
        way = patrol(fishes, minds, i, way)
        if is_blocked(fishes, minds, i):
            fishes.goal_speed[i] = min(fishes.goal_speed[i], np.float32(BLOCKED))
    set_urge(minds, i, way)


@kernel
def heading(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> Vector:
    """Unit vector to the waypoint, redrawn when it is reached or after a while.

    A fish on an errand keeps its waypoint.
    """
    minds.patience[i] -= minds.pause[i]
    here = vector(fishes.position[i])
    toward = minus(vector(minds.waypoint[i]), here)
    done = minds.patience[i] <= 0.0 or norm(toward) < ARRIVED_BL * fishes.length[i]
    if done and minds.errand[i] <= 0.0:
        redraw(fishes, minds, i, sea, clock)
        toward = minus(vector(minds.waypoint[i]), here)
    return times(1.0 / max(norm(toward), 1.0), toward)


@kernel
def redraw(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> None:
    """Draw a waypoint in free water, with a gentle climb or dive, and the patience for it.

    That of a school lies ahead of it, so that the school does not have to turn back.
    """
    here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    for attempt in range(LEADERS_ATTEMPTS if minds.leads[i] else ATTEMPTS):
        tick = clock.tick + (attempt << 40)
        if minds.home_range[i] < np.inf:
            store(minds.waypoint[i], _near_home(minds, i, sea, clock.seed, tick))
            break
        angle = 2.0 * np.pi * uniform(clock.seed, i, tick, ANGLE_PURPOSE)
        reach = ROAM * sea.radius * np.sqrt(uniform(clock.seed, i, tick, RADIUS_PURPOSE))
        x, y = reach * np.cos(angle), reach * np.sin(angle)
        floor = height_at(sea.floor, sea.half_width, x, y) + FLOOR_CM
        # Most life of a reef is in the lower half of the water.
        depth = uniform(clock.seed, i, tick, DEPTH_PURPOSE) ** 1.6
        if minds.kind[i] == PREDATOR:
            depth *= LOW
        rise = SLOPE * np.sqrt((x - here[0]) ** 2 + (y - here[1]) ** 2)
        z = min(max(floor + depth * (-SURFACE_CM - floor), here[2] - rise), here[2] + rise)
        store(minds.waypoint[i], (x, y, max(z, floor)))
        there = vector(minds.waypoint[i])
        way = minus(there, here)
        onward = dot(way, ahead) > AHEAD_COS * norm(way) and is_broad(sea, here, there)
        if _is_free(sea, there) and (not minds.leads[i] or onward):
            break
    low, high = PATIENCE_S
    share = uniform(clock.seed, i, clock.tick, PATIENCE_PURPOSE)
    way_s = norm(minus(vector(minds.waypoint[i]), here)) / (SLOWEST * fishes.fast[i])
    minds.patience[i] = low + (high - low) * share + way_s


@kernel
def _near_home(minds: Minds, i: int, sea: Sea, seed: int, tick: int) -> Vector:
    """A place within the range of fish i about its home, above the ground."""
    angle = 2.0 * np.pi * uniform(seed, i, tick, ANGLE_PURPOSE)
    reach = HOME_SHARE * minds.home_range[i] * np.sqrt(uniform(seed, i, tick, RADIUS_PURPOSE))
    rise = 0.5 * reach * uniform(seed, i, tick, DEPTH_PURPOSE)
    home = vector(minds.home[i])
    x, y = home[0] + reach * np.cos(angle), home[1] + reach * np.sin(angle)
    floor = height_at(sea.floor, sea.half_width, x, y) + HOME_FLOOR_CM
    return x, y, max(home[2] + rise, floor)


@kernel
def is_at_home(minds: Minds, i: int, place: Vector) -> bool:
    """True if a place lies within the range of fish i."""
    return norm(minus(place, vector(minds.home[i]))) <= minds.home_range[i]


@kernel
def _is_free(sea: Sea, p: Vector) -> bool:
    """True if no pillar or rock is near p."""
    free = True
    for k in range(len(sea.pillars)):
        free = free and from_pillar(sea.pillars[k], p)[1] >= FREE_CM
    for k in range(len(sea.rocks)):
        free = free and from_rock(sea.rocks[k], p)[1] >= FREE_CM
    return free


@kernel
def is_broad(sea: Sea, here: Vector, there: Vector) -> bool:
    """True if the straight way keeps BROAD_CM off every pillar and rock.

    A solid that is nearer at the start counts only if the way leads toward it.
    """
    way = minus(there, here)
    for k in range(len(sea.pillars)):
        t = ray_meets_pillar(sea.pillars[k], BROAD_CM, here, there)
        if t <= 1.0 and (t > 0.0 or dot(from_pillar(sea.pillars[k], here)[0], way) < 0.0):
            return False
    for k in range(len(sea.rocks)):
        t = ray_meets_rock(sea.rocks[k], BROAD_CM, here, there)
        if t <= 1.0 and (t > 0.0 or dot(from_rock(sea.rocks[k], here)[0], way) < 0.0):
            return False
    return True


@kernel
def cruise(fishes: Fishes, minds: Minds, i: int) -> float:
    """Cruising speed: of an errand, of the swim recommended against monotony, or the present.

    Predators patrol at a speed of their own.
    """
    if minds.errand[i] > 0.0:
        return float(minds.errand[i])
    if minds.kind[i] == PREDATOR:
        return patrol_speed(fishes, i)
    speed = float(fishes.goal_speed[i])
    if fishes.recommended[i] >= 0:
        speed = CRUISE[fishes.recommended[i]]
    return min(max(speed, LEADING if minds.leads[i] else CRUISE[0]), CRUISE[2])
