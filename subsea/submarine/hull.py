"""Dynamics of the submarine: thrust against drag, righting moment, soft limits."""

import math
from collections.abc import Callable

import numpy as np

from subsea.core.arrays import Array
from subsea.core.kernels import kernel
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import Vector, store
from subsea.scenario.schema import Bounds
from subsea.state import HULL_CM, Submarine
from subsea.submarine.helm import Helm

FloorHeight = Callable[[float, float], float]  # x, y in cm -> height of the seabed in cm

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

NO_SOLIDS = np.zeros((0, 7))


def settled_speed(share: float, full_cm_s: float, linear: float, quadratic: float) -> float:
    """The speed (cm/s or rad/s) at which drag balances `share` of full thrust.

    Full thrust settles at `full_cm_s`, so this solves
    ``linear v + quadratic v² = share (linear full + quadratic full²)``.
    """
    thrust = share * _thrust(full_cm_s, linear, quadratic)
    return (math.sqrt(linear**2 + 4.0 * quadratic * thrust) - linear) / (2.0 * quadratic)


def step_hull(
    submarine: Submarine,
    helm: Helm,
    dt: float,
    floor_height: FloorHeight,
    bounds: Bounds,
    pillars: Array = NO_SOLIDS,
    rocks: Array = NO_SOLIDS,
) -> None:
    """Advance the submarine by `dt` seconds, in place.

    Writes every array of `submarine`; the position and angles before the step go to its
    `previous_` arrays. `floor_height` gives the seabed, `bounds` the surface and the cylinder,
    `pillars` (k, 4) and `rocks` (k, 7), as in `state.Sea`, what stands in the way.
    """
    submarine.previous_position[:] = submarine.position
    submarine.previous_angles[:] = submarine.angles
    if helm.full_stop:
        helm = Helm(full_stop=True)
    _turn(submarine, helm, dt)
    _push(submarine, helm, dt)
    keep_clear(submarine, floor_height, bounds, pillars, rocks)
    submarine.position += dt * submarine.velocity
    for distance, normal in _solids(submarine, floor_height, pillars, rocks):
        submarine.position += max(0.5 * CLEARANCE_CM - distance, 0.0) * normal
    # The seabed may curve more than its slope predicts: never touch it.
    x, y, z = submarine.position
    submarine.position[2] = max(z, floor_height(x, y) + 0.5 * CLEARANCE_CM)


def hull_axes(heading: float, pitch: float) -> Array:
    """Rows ahead, left, up (3, 3): the axes of a hull without roll, world."""
    ch, sh, cp, sp = math.cos(heading), math.sin(heading), math.cos(pitch), math.sin(pitch)
    return np.array([[ch * cp, sh * cp, sp], [-sh, ch, 0.0], [-ch * sp, -sh * sp, cp]])


def _turn(submarine: Submarine, helm: Helm, dt: float) -> None:
    heading_rate, pitch_rate = submarine.rates
    thrust = helm.yaw * _thrust(YAW_RAD_S, LINEAR_YAW, QUADRATIC_YAW)
    linear = LINEAR_YAW + BRAKE * helm.full_stop
    heading_rate = _driven(heading_rate, thrust, linear, QUADRATIC_YAW, dt)
    # Spring and damper, solved implicitly: stable at any dt.
    stiffness = RIGHTING**2
    most = RIGHTING_MOST / stiffness
    error = np.clip(helm.pitch * MAX_PITCH - submarine.angles[1], -most, most)
    pitch_rate = (pitch_rate + dt * stiffness * error) / (
        1.0 + 2.0 * RIGHTING * dt + stiffness * dt**2
    )
    submarine.rates[:] = heading_rate, pitch_rate
    submarine.angles += dt * submarine.rates
    submarine.angles[1] = np.clip(submarine.angles[1], -MAX_PITCH, MAX_PITCH)


def _push(submarine: Submarine, helm: Helm, dt: float) -> None:
    axes = hull_axes(*submarine.angles)
    ahead, left, up = axes @ submarine.velocity
    brake = BRAKE * helm.full_stop
    full_surge = AHEAD_CM_S if helm.surge >= 0.0 else ASTERN_CM_S
    surge = helm.surge * _thrust(full_surge, LINEAR_ALONG, QUADRATIC_ALONG)
    heave = helm.heave * _thrust(HEAVE_CM_S, LINEAR_ACROSS, QUADRATIC_ACROSS)
    along, across = LINEAR_ALONG + brake, LINEAR_ACROSS + brake
    x = _driven(ahead, surge, along, QUADRATIC_ALONG, dt)
    y = _driven(left, 0.0, across, QUADRATIC_ACROSS, dt)
    z = _driven(up, heave, across, QUADRATIC_ACROSS, dt)
    change = np.array([x - ahead, y - left, z - up])
    change *= min(1.0, dt * ACCELERATION_CM_S2 / max(float(np.linalg.norm(change)), 1e-9))
    submarine.velocity += change @ axes


def _solids(
    submarine: Submarine, floor_height: FloorHeight, pillars: Array, rocks: Array
) -> list[tuple[float, Array]]:
    """Distances and outward normals of the solids within two seconds' reach."""
    x, y, z = (float(value) for value in submarine.position)
    found = _near_solids(pillars, rocks, (x, y, z), floor_height(x, y))
    return [(row[0], row[1:]) for row in found]


@kernel
def _near_solids(pillars: Array, rocks: Array, p: Vector, floor: float) -> Array:
    """Rows (k, 4): distance and outward normal of the pillars and rocks near p, over the floor."""
    reach = CLEARANCE_CM + 2.0 * AHEAD_CM_S
    found, count = np.empty((len(pillars) + len(rocks), 4)), 0
    for k in range(len(pillars)):
        if math.hypot(pillars[k, 0] - p[0], pillars[k, 1] - p[1]) < pillars[k, 2] + reach:
            normal, found[count, 0] = from_pillar(pillars[k], p)
            store(found[count, 1:], normal)
            count += 1
    for k in range(len(rocks)):
        size = max(rocks[k, 3], rocks[k, 4])
        if math.hypot(rocks[k, 0] - p[0], rocks[k, 1] - p[1]) < size + reach:
            normal, found[count, 0] = from_rock(rocks[k], p)
            if normal[2] < 0.0 and rocks[k, 2] - rocks[k, 5] < floor + 2.0 * CLEARANCE_CM:
                # A rock without room beneath must not press the hull into the seabed.
                level = max(math.hypot(normal[0], normal[1]), 1e-3)
                normal = (normal[0] / level, normal[1] / level, 0.0)
            store(found[count, 1:], normal)
            count += 1
    return found[:count]


def keep_clear(
    submarine: Submarine, floor_height: FloorHeight, bounds: Bounds, pillars: Array, rocks: Array
) -> None:
    """Limit the speed toward every wall in proportion to its distance."""
    x, y, z = submarine.position
    slope_x = (floor_height(x + PROBE_CM, y) - floor_height(x - PROBE_CM, y)) / (2.0 * PROBE_CM)
    slope_y = (floor_height(x, y + PROBE_CM) - floor_height(x, y - PROBE_CM)) / (2.0 * PROBE_CM)
    floor_normal = np.array([-slope_x, -slope_y, 1.0])
    floor_normal /= np.linalg.norm(floor_normal)
    radius = math.hypot(x, y)
    inward = np.array([-x, -y, 0.0]) / max(radius, 1.0)
    walls = [
        *_solids(submarine, floor_height, pillars, rocks),
        (bounds.radius_cm - radius, inward),
        (-z, np.array([0.0, 0.0, -1.0])),
        ((z - floor_height(x, y)) * floor_normal[2], floor_normal),
    ]
    for distance, normal in walls:
        allowed = max((distance - CLEARANCE_CM) / APPROACH_S, -RETURN_CM_S)
        excess = -float(submarine.velocity @ normal) - allowed
        if excess > 0.0:
            submarine.velocity += excess * normal


def _thrust(full_speed: float, linear: float, quadratic: float) -> float:
    """The thrust per mass that settles at `full_speed`."""
    return (linear + quadratic * full_speed) * full_speed


def _driven(speed: float, thrust: float, linear: float, quadratic: float, dt: float) -> float:
    """The speed after `dt` with implicit drag, which never reverses the motion."""
    return float((speed + dt * thrust) / (1.0 + dt * (linear + quadratic * abs(speed))))
