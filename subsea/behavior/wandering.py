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
from subsea.geometry.walls import WALL_CM
from subsea.kernels import kernel
from subsea.state import PREDATOR, Clock, Fishes, Minds, Nature, Sea

ROAM = 0.8  # share of the sea's radius within which waypoints lie
SLOPE = 0.3  # steepest way to a waypoint
ARRIVED_BL = 3.0  # distance at which a waypoint is reached
PATIENCE_S = (2.0, 12.0)  # how long a fish heads for a waypoint, beyond the time for the way ...
SLOWEST = 0.3  # ... at this share of its fastest speed
FLOOR_CM = 75.0  # height of waypoints above the floor ...
PROWLS = 0.35  # share of this height for predators, which patrol below their prey
SURFACE_CM = 80.0  # ... their depth ...
FREE_CM = 40.0  # ... and their distance from solids, ...
ATTEMPTS = 6  # ... within this many attempts
LEADERS_ATTEMPTS = 24  # for a leader, whose waypoint must also ...
AHEAD_COS = -0.2  # ... not be behind it, and be ...
BROAD_CM = 100.0  # ... this far from solids, which split a school
HOME_SHARE = 0.7  # of its range within which a fish with a home wanders ...
HOME_FLOOR_CM = 12.0  # ... at least this high
LOW, DESCENT = 1.6, 2.4  # power that draws waypoints low, and how much more it is by night
CRUISE = (0.1, 0.62, 0.85)  # shares of the fastest speed: hovering, medium and brisk cruising
LEADING = 0.45  # a leader keeps its school moving
TRACKS = 0.6  # desire of a fish that follows an odour
BOUND = 0.7  # desire of a fish on an errand: stronger than curiosity
WAITING = 0.2  # its speed while no companion is near, or many are left behind
AHEAD_BL = 1.5  # distance ahead at which a fish that keeps to the ground feels for it
GENTLE_RAD = np.radians(30.0)  # greatest turn to a waypoint of such a fish: it glides in wide arcs
BERTH_BL = 2.5  # distance of waypoints from the wall, for fishes that are long for their sea ...
LEAST_ROAM = 0.4  # ... at this share of its radius or more
HOVERS, BRISK = 0.25, 0.735  # limits between these
OWN_PACE_S = 2.0  # time constant with which a fish that begins to wander finds its own pace
RESTLESS = 2.0  # power of the activity by which pauses are rarer
ACTIVITY_PURPOSE = np.int64(166)  # key of the random numbers
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
    fishes.goal_speed[i] = cruise(fishes, minds, i, clock)
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
    if minds.cruise_height[i, 0] < np.inf and minds.errand[i] <= 0.0:
        toward = _along_ground(fishes, minds, i, sea, toward)
    return times(1.0 / max(norm(toward), 1.0), toward)


@kernel
def _along_ground(fishes: Fishes, minds: Minds, i: int, sea: Sea, toward: Vector) -> Vector:
    """Way to a waypoint that keeps its height over the ground, in a wide arc.

    The higher ground counts, below the fish or ahead of it. Toward the wall the fish turns as hard
    as it can.
    """
    here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    course = np.arctan2(ahead[1], ahead[0])
    turn = np.arctan2(toward[1], toward[0]) - course
    turn -= 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
    reach = AHEAD_BL * float(fishes.length[i])
    x, y = here[0] + reach * np.cos(course), here[1] + reach * np.sin(course)
    edge = sea.radius - BERTH_BL * float(fishes.length[i])
    hardest = GENTLE_RAD if x * x + y * y < edge * edge else np.pi
    course += min(max(turn, -hardest), hardest)
    x, y = np.cos(course), np.sin(course)
    ground = max(
        height_at(sea.floor, sea.half_width, here[0], here[1]),
        height_at(sea.floor, sea.half_width, here[0] + reach * x, here[1] + reach * y),
    )
    place = vector(minds.waypoint[i])
    over = place[2] - height_at(sea.floor, sea.half_width, place[0], place[1])
    slope = min(max((ground + over - here[2]) / reach, -SLOPE), SLOPE)
    far = max(norm(toward), 1.0)
    return far * x, far * y, far * slope


@kernel
def redraw(fishes: Fishes, minds: Minds, i: int, sea: Sea, clock: Clock) -> None:
    """Draw a waypoint in free water, with a gentle climb or dive, and the patience for it.

    It is where the fish likes light and temperature, as far as the climb allows. That of a school
    lies ahead of it, so that the school does not have to turn back, and likewise that of a fish
    that keeps to the ground.
    """
    here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    plans = minds.leads[i] or minds.cruise_height[i, 0] < np.inf
    for attempt in range(LEADERS_ATTEMPTS if plans else ATTEMPTS):
        tick = clock.tick + (attempt << 40)
        if minds.home_range[i] < np.inf:
            store(minds.waypoint[i], _near_home(minds, i, sea, clock.seed, tick))
            break
        angle = 2.0 * np.pi * uniform(clock.seed, i, tick, ANGLE_PURPOSE)
        roam = max(min(ROAM, 1.0 - BERTH_BL * fishes.length[i] / sea.radius), LEAST_ROAM)
        reach = roam * sea.radius * np.sqrt(uniform(clock.seed, i, tick, RADIUS_PURPOSE))
        x, y = reach * np.cos(angle), reach * np.sin(angle)
        if fishes.period[0] > 0.0:  # a box has no middle: anywhere in it, evenly
            x = here[0] + fishes.period[0] * (angle / (2.0 * np.pi) - 0.5)
            y = here[1] + fishes.period[1] * (uniform(clock.seed, i, tick, RADIUS_PURPOSE) - 0.5)
        floor = height_at(sea.floor, sea.half_width, x, y) + FLOOR_CM
        low, high = _liked_heights(minds, i, floor)
        # Most life of a reef is in the lower half of the water, by night near the ground.
        power = LOW + DESCENT * (1.0 - sea.sky[1])
        depth = uniform(clock.seed, i, tick, DEPTH_PURPOSE) ** power
        if minds.kind[i] == PREDATOR:
            depth *= PROWLS
        rise = SLOPE * np.sqrt((x - here[0]) ** 2 + (y - here[1]) ** 2)
        z = min(max(low + depth * (high - low), here[2] - rise), here[2] + rise)
        lowest, highest = minds.cruise_height[i]
        if lowest < np.inf:
            # Never so high that it would be nearer to the surface.
            over = lowest + depth * (highest - lowest)
            z = floor - FLOOR_CM + min(over, 0.5 * (FLOOR_CM - floor))
        store(minds.waypoint[i], (x, y, max(z, floor)))
        there = vector(minds.waypoint[i])
        way = minus(there, here)
        suits = -minds.comfort[i, 1] <= high and low <= -minds.comfort[i, 0]
        onward = dot(way, ahead) > AHEAD_COS * norm(way) and is_broad(sea, here, there)
        if suits and _is_free(sea, there) and (not plans or onward):
            break
    low, high = PATIENCE_S
    share = uniform(clock.seed, i, clock.tick, PATIENCE_PURPOSE)
    way_s = norm(minus(vector(minds.waypoint[i]), here)) / (SLOWEST * fishes.fast[i])
    minds.patience[i] = low + (high - low) * share + way_s


@kernel
def _liked_heights(minds: Minds, i: int, floor: float) -> tuple[float, float]:
    """Lowest and highest z of waypoints over a `floor`: where fish i likes light and warmth.

    Both are the nearest one where the water has no such depth.
    """
    top = max(-SURFACE_CM, floor)
    high = min(max(-float(minds.comfort[i, 0]), floor), top)
    low = max(min(-float(minds.comfort[i, 1]), high), floor)
    return low, high


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
    """True if the straight way keeps BROAD_CM off every pillar and rock; walls split no school.

    A solid that is nearer at the start counts only if the way leads toward it.
    """
    way = minus(there, here)
    for k in range(len(sea.pillars)):
        if sea.pillars[k, 2] >= WALL_CM:
            continue
        t = ray_meets_pillar(sea.pillars[k], BROAD_CM, here, there)
        if t <= 1.0 and (t > 0.0 or dot(from_pillar(sea.pillars[k], here)[0], way) < 0.0):
            return False
    for k in range(len(sea.rocks)):
        t = ray_meets_rock(sea.rocks[k], BROAD_CM, here, there)
        if t <= 1.0 and (t > 0.0 or dot(from_rock(sea.rocks[k], here)[0], way) < 0.0):
            return False
    return True


@kernel
def cruise(fishes: Fishes, minds: Minds, i: int, clock: Clock) -> float:
    """Cruising speed: of an errand, of the swim recommended against monotony, or the present.

    An active fish is faster, and often cruises where it is recommended to hover; a lazy one hovers
    where it should cruise. After another behavior a fish eases to its own pace. Predators patrol at
    a speed of their own.
    """
    if minds.errand[i] > 0.0:
        return float(minds.errand[i])
    activity = float(minds.activity[i])
    if minds.kind[i] == PREDATOR:
        return min(activity * patrol_speed(fishes, i), 1.0)
    speed = float(fishes.goal_speed[i])
    own = CRUISE[0] if speed < HOVERS else CRUISE[1 if speed < BRISK * activity else 2]
    speed /= activity
    speed += min(minds.pause[i] / OWN_PACE_S, 1.0) * (own - speed)
    advice = int(fishes.recommended[i])
    if advice >= 0:
        chance = uniform(clock.seed, i, clock.tick, ACTIVITY_PURPOSE)
        if advice == 0 and chance < 1.0 - activity**-RESTLESS:
            advice = 1
        elif advice == 1 and chance < 1.0 - activity**RESTLESS:
            advice = 0
        speed = CRUISE[advice]
    least = LEADING if minds.leads[i] else CRUISE[0]
    return min(activity * min(max(speed, least), CRUISE[2]), 1.0)
