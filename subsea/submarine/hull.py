"""Dynamics of the submarine: thrust against drag, righting moment, soft limits."""

import math

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.height_field import height_at
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import Vector, dot, norm, plus, store, times, vector
from subsea.kernels import kernel
from subsea.state import HULL_CM, Sea, Submarine
from subsea.submarine.helm import Helm

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
