"""The submarine: commands of the pilot (SMC §8.2), dynamics, tours, and rails.

On a rail a tour sets the pose directly, without thrust, drag and slip. Position and velocity are
part of the state as usual, so fishes, bow wave and seaweed react as to a piloted hull.
"""

import math
from typing import NamedTuple

import msgspec
import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.disk_cache import cached
from subsea.base.errors import UserError, unknown
from subsea.geometry.curves import Curve, curve_at, curve_through
from subsea.geometry.solids import from_pillar, from_rock, height_at
from subsea.geometry.vector import Vector, dot, norm, plus, store, times, vector
from subsea.geometry.walls import is_wall
from subsea.kernels import kernel
from subsea.scenario.schema import AUTOPILOT, Bounds, Scenario, TourTable, Waypoint
from subsea.state import HULL_CM, Sea, State, Submarine


class Helm(NamedTuple):
    """Commands in [-1, 1]: shares of full thrust.

    =============  ==========================  ============================
    field          positive                    negative
    =============  ==========================  ============================
    ``surge``      accelerate ahead            decelerate, then reverse
    ``yaw``        turn left                   turn right
    ``pitch``      nose up                     nose down
    ``heave``      rise                        dive
    =============  ==========================  ============================

    ``full_stop`` overrides all: the hull brakes, levels and holds its heading.
    """

    surge: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    heave: float = 0.0
    full_stop: bool = False


NEUTRAL = Helm()
STATION = Helm(full_stop=True)


# Speeds at full thrust: fast enough to follow a school, slow enough against motion sickness.
AHEAD_CM_S = 120.0
ASTERN_CM_S = 60.0
HEAVE_CM_S = 70.0
YAW_RAD_S = math.radians(40.0)
MAX_PITCH = math.radians(60.0)  # rad; the horizon stays in view

# Drag decelerates by (LINEAR + QUADRATIC * |v|) * v. It is far larger sideways than ahead, so the
# course follows the nose.
LINEAR_ALONG, QUADRATIC_ALONG = 0.30, 2.4e-3  # 1/s, 1/cm
LINEAR_ACROSS, QUADRATIC_ACROSS = 1.0, 6.0e-3
LINEAR_YAW, QUADRATIC_YAW = 1.2, 1.5  # 1/s, 1/rad
BRAKE = 2.2  # 1/s, added to every linear term by a full stop: 120 cm/s to 1 cm/s in two seconds

# Limit for thrust, drag and brake together, as for standing passengers of a tram.
ACCELERATION_CM_S2 = 150.0

RIGHTING = 3.0  # 1/s; buoyancy above the ballast levels the hull, critically damped
RIGHTING_MOST = 4.0  # rad/s²; limit with the diving planes: the nose moves at most 36° a second

CLEARANCE_CM = HULL_CM
APPROACH_S = 1.0  # a wall at distance d is approached at d / APPROACH_S at most, so never reached
RETURN_CM_S = 40.0  # fastest push back for a hull that is too close
PROBE_CM = 25.0  # half the baseline of the seabed's slope


def settled_speed(share: float, full_cm_s: float, linear: float, quadratic: float) -> float:
    """The speed (cm/s or rad/s) at which drag balances `share` of full thrust.

    Full thrust settles at `full_cm_s`, so this solves
    ``linear v + quadratic v² = share (linear full + quadratic full²)``.
    """
    thrust = share * _thrust(full_cm_s, linear, quadratic)
    return (math.sqrt(linear**2 + 4.0 * quadratic * thrust) - linear) / (2.0 * quadratic)


def step_hull(submarine: Submarine, helm: Helm, dt: float, sea: Sea) -> None:
    """Advance the submarine by `dt` seconds in the room and between the solids of `sea`, in place.

    Writes every array of `submarine`; the position and angles before the step go to its
    `previous_` arrays.
    """
    submarine.previous_position[:] = submarine.position
    submarine.previous_angles[:] = submarine.angles
    shares = Helm() if helm.full_stop else helm
    _advance(
        submarine.position, submarine.velocity, submarine.angles, submarine.rates,
        (float(shares.surge), float(shares.yaw), float(shares.pitch), float(shares.heave)),
        BRAKE if helm.full_stop else 0.0, dt, sea,
    )  # fmt: skip


@kernel
def _advance(
    position: Array,
    velocity: Array,
    angles: Array,
    rates: Array,
    shares: tuple[float, float, float, float],
    brake: float,
    dt: float,
    sea: Sea,
) -> None:
    """Turn, push and move a hull by `dt` seconds, in place.

    `shares` are those of a helm: surge, yaw, pitch, heave. `brake`, 1/s, adds to linear drag.
    """
    surge, yaw, pitch, heave = shares
    _turn(angles, rates, yaw, pitch, brake, dt)
    _push(velocity, angles, surge, heave, brake, dt)
    keep_clear(position, velocity, sea)
    for axis in range(3):
        position[axis] += dt * velocity[axis]
    for wall in _near_solids(sea, vector(position)):
        for axis in range(3):
            position[axis] += max(0.5 * CLEARANCE_CM - wall[0], 0.0) * wall[1 + axis]
    # The seabed may curve more than its slope predicts: never touch it.
    position[2] = max(position[2], _floor(sea, position[0], position[1]) + 0.5 * CLEARANCE_CM)


def hull_axes(heading: float, pitch: float) -> Array:
    """Rows ahead, left, up (3, 3): the axes of a hull without roll, world."""
    return np.array(_axes(heading, pitch))


@kernel
def _axes(heading: float, pitch: float) -> tuple[Vector, Vector, Vector]:
    ch, sh, cp, sp = math.cos(heading), math.sin(heading), math.cos(pitch), math.sin(pitch)
    return (ch * cp, sh * cp, sp), (-sh, ch, 0.0), (-ch * sp, -sh * sp, cp)


@kernel
def _turn(angles: Array, rates: Array, yaw: float, pitch: float, brake: float, dt: float) -> None:
    thrust = yaw * _thrust(YAW_RAD_S, LINEAR_YAW, QUADRATIC_YAW)
    rates[0] = _driven(rates[0], thrust, LINEAR_YAW + brake, QUADRATIC_YAW, dt)
    # Spring and damper, solved implicitly: stable at any dt.
    stiffness = RIGHTING**2
    most = RIGHTING_MOST / stiffness
    error = min(max(pitch * MAX_PITCH - angles[1], -most), most)
    rates[1] = (rates[1] + dt * stiffness * error) / (1.0 + 2.0 * RIGHTING * dt + stiffness * dt**2)
    angles[0] += dt * rates[0]
    angles[1] = min(max(angles[1] + dt * rates[1], -MAX_PITCH), MAX_PITCH)


@kernel
def _push(
    velocity: Array, angles: Array, surge: float, heave: float, brake: float, dt: float
) -> None:
    ahead, left, up = _axes(angles[0], angles[1])
    moves = vector(velocity)
    full_surge = AHEAD_CM_S if surge >= 0.0 else ASTERN_CM_S
    thrust = surge * _thrust(full_surge, LINEAR_ALONG, QUADRATIC_ALONG)
    lift = heave * _thrust(HEAVE_CM_S, LINEAR_ACROSS, QUADRATIC_ACROSS)
    along, across = LINEAR_ALONG + brake, LINEAR_ACROSS + brake
    x, y, z = dot(ahead, moves), dot(left, moves), dot(up, moves)
    x = _driven(x, thrust, along, QUADRATIC_ALONG, dt) - x
    y = _driven(y, 0.0, across, QUADRATIC_ACROSS, dt) - y
    z = _driven(z, lift, across, QUADRATIC_ACROSS, dt) - z
    change = plus(plus(times(x, ahead), times(y, left)), times(z, up))
    share = min(1.0, dt * ACCELERATION_CM_S2 / max(norm(change), 1e-9))
    store(velocity, plus(moves, times(share, change)))


@kernel
def _near_solids(sea: Sea, p: Vector) -> Array:
    """Rows (k, 4): distance and outward normal of the solids within two seconds' reach of p."""
    reach = CLEARANCE_CM + 2.0 * AHEAD_CM_S
    found, count = np.empty((len(sea.pillars) + len(sea.rocks), 4)), 0
    for pillar in sea.pillars:
        if math.hypot(pillar[0] - p[0], pillar[1] - p[1]) < pillar[2] + reach:
            normal, found[count, 0] = from_pillar(pillar, p)
            store(found[count, 1:], normal)
            count += 1
    for rock in sea.rocks:
        size = max(rock[3], rock[4])
        if math.hypot(rock[0] - p[0], rock[1] - p[1]) < size + reach:
            normal, found[count, 0] = from_rock(rock, p)
            if normal[2] < 0.0 and rock[2] - rock[5] < _floor(sea, p[0], p[1]) + 2.0 * CLEARANCE_CM:
                # A rock without room beneath must not press the hull into the seabed.
                level = max(math.hypot(normal[0], normal[1]), 1e-3)
                normal = (normal[0] / level, normal[1] / level, 0.0)
            store(found[count, 1:], normal)
            count += 1
    return found[:count]


@kernel
def keep_clear(position: Array, velocity: Array, sea: Sea) -> None:
    """Limit the velocity (3,) toward every wall in proportion to its distance, in place."""
    x, y, z = vector(position)
    for wall in _near_solids(sea, (x, y, z)):
        _slow_toward(velocity, wall[0], (wall[1], wall[2], wall[3]))
    radius = math.hypot(x, y)
    inward = times(-1.0 / max(radius, 1.0), (x, y, 0.0))
    _slow_toward(velocity, sea.radius - radius, inward)
    _slow_toward(velocity, -z, (0.0, 0.0, -1.0))
    slope_x = (_floor(sea, x + PROBE_CM, y) - _floor(sea, x - PROBE_CM, y)) / (2.0 * PROBE_CM)
    slope_y = (_floor(sea, x, y + PROBE_CM) - _floor(sea, x, y - PROBE_CM)) / (2.0 * PROBE_CM)
    normal = (-slope_x, -slope_y, 1.0)
    normal = times(1.0 / norm(normal), normal)
    _slow_toward(velocity, (z - _floor(sea, x, y)) * normal[2], normal)


@kernel
def _slow_toward(velocity: Array, distance: float, normal: Vector) -> None:
    """Limit the velocity toward a wall at a distance, with an outward normal."""
    allowed = max((distance - CLEARANCE_CM) / APPROACH_S, -RETURN_CM_S)
    excess = -dot(vector(velocity), normal) - allowed
    if excess > 0.0:
        store(velocity, plus(vector(velocity), times(excess, normal)))


@kernel
def _floor(sea: Sea, x: float, y: float) -> float:
    """Height of the seabed with all that grows on it, cm."""
    return height_at(sea.floor, sea.half_width, x, y)


@kernel
def _thrust(full_speed: float, linear: float, quadratic: float) -> float:
    """The thrust per mass that settles at `full_speed`."""
    return (linear + quadratic * full_speed) * full_speed


@kernel
def _driven(speed: float, thrust: float, linear: float, quadratic: float, dt: float) -> float:
    """The speed after `dt` with implicit drag, which never reverses the motion."""
    return float((speed + dt * thrust) / (1.0 + dt * (linear + quadratic * abs(speed))))


GAZE = 2.5  # 1/s: it turns like a head, critically damped ...
TURN_RAD_S = math.radians(22.0)  # ... and no faster than is pleasant to watch


class Rail(NamedTuple):
    """The pose of the hull after a tick, in place of a `Helm`."""

    position: Array  # (3,) cm
    velocity: Array  # (3,) cm/s
    angles: tuple[float, float]  # rad, heading and pitch to turn to
    cut: bool = False  # jump there at once, as a film cut


def ride(submarine: Submarine, rail: Rail, dt: float) -> None:
    """Advance the submarine by `dt` seconds along its rail, in place."""
    if rail.cut:
        board(submarine, rail, rail)
        return
    submarine.previous_position[:] = submarine.position
    submarine.previous_angles[:] = submarine.angles
    submarine.position[:] = rail.position
    submarine.velocity[:] = rail.velocity
    error = np.array(rail.angles) - submarine.angles
    error[0] = math.remainder(error[0], math.tau)
    stiffness = GAZE**2  # a spring and its damper, solved implicitly: stable at any dt
    rates = (submarine.rates + dt * stiffness * error) / (1.0 + 2.0 * GAZE * dt + stiffness * dt**2)
    submarine.rates[:] = np.clip(rates, -TURN_RAD_S, TURN_RAD_S)
    submarine.angles += dt * submarine.rates
    submarine.angles[1] = np.clip(submarine.angles[1], -MAX_PITCH, MAX_PITCH)


def board(submarine: Submarine, before: Rail, now: Rail) -> None:
    """Put the submarine on a rail between two ticks."""
    submarine.previous_position[:], submarine.previous_angles[:] = before.position, before.angles
    submarine.position[:], submarine.angles[:] = now.position, now.angles
    submarine.velocity[:] = now.velocity
    submarine.rates[:] = 0.0


AHEAD_S = 2.0  # how far along the path a tour that looks ahead looks
NEAR_CM = 250.0  # scale of the distance that weights followed fishes
PROBE_S = 0.1  # interval at which a path is checked


class Course(NamedTuple):
    """A tour that is ready to run."""

    curve: Curve
    gaze_s: Array  # (g,) times of the gaze targets ...
    gazes: tuple[Waypoint, ...]  # ... of these waypoints
    species: tuple[str, ...]  # in the order of `Fishes.species`

    @property
    def seconds(self) -> float:
        """Duration of the tour, or of one round."""
        return float(self.curve.times[-1])


def course_of(scenario: Scenario, name: str) -> Course:
    """The tour `name` of a scenario; an unknown name is a UserError."""
    tours = {tour.name: tour for tour in scenario.tour}
    if name not in tours:
        raise unknown("tour", name, [AUTOPILOT, *tours])
    return _course(tours[name], scenario)


def rail_at(course: Course, state: State, t: float) -> Rail:
    """Position and gaze `t` seconds after the start, in the present sea."""
    place, velocity = curve_at(course.curve, t)
    if course.curve.loop:
        t %= course.seconds
    k = int(np.searchsorted(course.gaze_s, t, side="right"))
    before, after = max(k - 1, 0), min(k, len(course.gazes) - 1)
    heading, pitch = _toward(course, course.gazes[before], state, place, t)
    if course.gaze_s[after] > course.gaze_s[before]:
        share = (t - course.gaze_s[before]) / (course.gaze_s[after] - course.gaze_s[before])
        share = _eased(min(max(share, 0.0), 1.0))
        other, steep = _toward(course, course.gazes[after], state, place, t)
        heading += share * math.remainder(other - heading, math.tau)
        pitch += share * (steep - pitch)
    return Rail(place, velocity, (heading, pitch))


def paths_of(scenario: Scenario) -> Array:
    """The paths of all tours as lines (n, 2, 3), cm."""
    lines = [np.zeros((0, 2, 3))]
    for tour in scenario.tour:
        curve = _course(tour, scenario).curve
        places = [curve_at(curve, t)[0] for t in np.arange(0.0, curve.times[-1], 5.0 * PROBE_S)]
        lines.append(np.stack([places[:-1], places[1:]], axis=1))
    return np.concatenate(lines)


def check_tours(scenario: Scenario, sea: Sea, rocks: list[str], stored: bool = True) -> None:
    """Raise a UserError for a tour that leaves the sea, is too near solids, or too fast.

    `rocks` are the names of the rocks of the sea. `stored`: use the disk cache.
    """
    curves = [_course(tour, scenario).curve for tour in scenario.tour]
    given = curves, sea, scenario.bounds, rocks
    fault = cached(_first_fault, *given) if stored else _first_fault(*given)
    if fault is not None:
        k, t, what = fault
        leg = int(np.searchsorted(curves[k].times, t, side="right")) - 1
        raise UserError(
            f"`tour[{k}]` {scenario.tour[k].name!r} {what}, {t:.1f} s after its start, "
            f"between `waypoint[{leg}]` and `waypoint[{leg + 1}]`",
            key=f"tour[{k}]",
        )


def _first_fault(
    curves: list[Curve], sea: Sea, bounds: Bounds, rocks: list[str]
) -> tuple[int, float, str] | None:
    """The first fault of any course: its index, the time in seconds, and a message."""
    for k, curve in enumerate(curves):
        times = np.arange(0.0, curve.times[-1], PROBE_S).tolist()
        path = [curve_at(curve, t) for t in times]
        near = _near_rocks(np.array([place for place, _ in path]), sea)
        beside = sea._replace(rocks=sea.rocks[near])
        names = [rocks[number] for number in near.tolist()]
        for t, (place, velocity) in zip(times, path, strict=True):
            if fault := _fault(place, velocity, beside, bounds, names):
                return k, t, fault
    return None


def _near_rocks(places: Array, sea: Sea) -> Ints:
    """Indices of the rocks that may lie within `HULL_CM` of a place (n, 3), by `from_rock`."""
    half = sea.rocks[:, 3:6]
    # Farther away the distance is larger, also where it is only approximate: see `far_from_rock`.
    reach = half.max(axis=1) * (1.0 + HULL_CM / half.min(axis=1))
    away = np.linalg.norm(places[:, None] - sea.rocks[:, :3], axis=2).min(axis=0)
    return np.flatnonzero(away <= reach + 1.0)


def _course(tour: TourTable, scenario: Scenario) -> Course:
    times = np.array([point.time_s for point in tour.waypoint])
    places = np.array([point.position_cm for point in tour.waypoint])
    looking = [point for point in tour.waypoint if point.looks]
    looking = looking or [msgspec.structs.replace(tour.waypoint[0], ahead=True)]
    if tour.loop:  # the last gaze is the first
        first, last = looking[0], looking[-1]
        period = float(times[-1])
        looking = [_later(last, -period), *looking, _later(first, period)]
    return Course(
        curve_through(times, places, tour.loop),
        np.array([point.time_s for point in looking]),
        tuple(looking),
        tuple(scenario.species),
    )


def _later(point: Waypoint, seconds: float) -> Waypoint:
    return msgspec.structs.replace(point, time_s=point.time_s + seconds)


def _toward(
    course: Course, gaze: Waypoint, state: State, place: Array, t: float
) -> tuple[float, float]:
    """Heading and pitch (rad) of a waypoint's gaze target; the present ones if it is gone."""
    if gaze.look_at_cm:
        way = np.array(gaze.look_at_cm) - place
    elif gaze.follow:
        fishes, species = state.fishes, course.species.index(gaze.follow)
        there = fishes.position[(fishes.species == species) & fishes.alive]
        way = middle_of(there, place) - place
    else:
        start = t if course.curve.loop else min(t, course.seconds - AHEAD_S)
        way = curve_at(course.curve, start + AHEAD_S)[0] - curve_at(course.curve, start)[0]
    return angles_of(way, state)


def angles_of(way: Array, state: State) -> tuple[float, float]:
    """Heading and pitch (rad) along a `way` (3,); the present ones if it is too short."""
    level = math.hypot(way[0], way[1])
    if level + abs(way[2]) < 1.0:
        heading, pitch = state.submarine.angles
        return float(heading), float(pitch)
    return math.atan2(way[1], way[0]), math.atan2(way[2], level)


def middle_of(there: Array, place: Array) -> Array:
    """The mean (3,) of places (n, 3), weighted to those near `place`; `place` if none."""
    if not len(there):
        return place
    there = there.astype(np.float64)
    weight = 1.0 / (1.0 + ((there - place) ** 2).sum(axis=1) / NEAR_CM**2) ** 2
    return np.asarray((weight[:, None] * there).sum(axis=0) / weight.sum())


def _eased(share: float) -> float:
    """From 0 to 1 with a level start and end."""
    return share * share * (3.0 - 2.0 * share)


def _fault(place: Array, velocity: Array, sea: Sea, bounds: Bounds, rocks: list[str]) -> str | None:
    """The fault of a hull at `place` with this velocity as a message, or None."""
    speed = float(np.linalg.norm(velocity))
    if speed > AHEAD_CM_S:
        return f"moves at {speed:.0f} cm/s, expected at most {AHEAD_CM_S:g}"
    x, y, z = place
    gaps = {"the rim of the sea": bounds.radius_cm - math.hypot(x, y), "the surface": -z}
    gaps |= gaps_at(vector(place), sea, rocks)
    nearest = min(gaps, key=lambda name: gaps[name])
    if gaps[nearest] >= HULL_CM:
        return None
    gap = math.floor(10.0 * gaps[nearest]) / 10.0  # rounded down: it is less than expected
    return f"is {gap:.1f} cm from {nearest}, expected at least {HULL_CM:g}"


def gaps_at(place: tuple[float, float, float], sea: Sea, rocks: list[str]) -> dict[str, float]:
    """Measure the distances of a place from seabed, reef and solids, by their names.

    `rocks` names each rock of the sea; those of one name count as one solid.
    """
    x, y, z = place
    gaps = {
        "the seabed": z - height_at(sea.heights, sea.half_width, x, y),
        "the reef": z - height_at(sea.floor, sea.half_width, x, y),
    }
    glass = is_wall(sea.pillars)
    for k, row in enumerate(sea.pillars):
        name = "a wall of the tank" if glass[k] else f"`pillar[{k}]`"
        gaps[name] = min(from_pillar(row, place)[1], gaps.get(name, math.inf))
    for name, row in zip(rocks, sea.rocks, strict=True):
        gaps[name] = min(from_rock(row, place)[1], gaps.get(name, math.inf))
    return gaps
