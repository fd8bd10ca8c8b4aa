"""The current: uniform and oscillating, with a source around each solid (Tu §8.1); bow waves."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import from_pillar, from_turned_rock
from subsea.geometry.vector import (
    ZERO,
    Vector,
    dot,
    minus,
    norm,
    plus,
    store,
    times,
    unit,
    vector,
)
from subsea.habitat.rocks import COSINE, FELT_CM, SINE, WIDE, RockCells, is_felt, rocks_near
from subsea.kernels import kernel
from subsea.state import HULL_CM, Fishes, Sea

PERIOD_S = 14.0
STILL = 0.0, 0.0
EAST = 1.0, 0.0, 0.0
SOURCE_CM = 40.0  # distance at which a source cancels the current: no water flows in
SPAN = FELT_CM / SOURCE_CM  # multiple of it at which a source has 4% of its strength, and ends
REACH_CM = 1.5 * FELT_CM  # from the box of a rock: far away `from_rock` is too short


def flow_at(
    current_cm_s: tuple[float, float], time_s: float, stream_cm_s: tuple[float, float] = STILL
) -> Array:
    """Velocity of the uniform current (3,) in cm/s: v^u = a·sin(ωt) along a fixed direction.

    A steady stream is added to it.
    """
    swing = np.sin(2 * np.pi * time_s / PERIOD_S)
    x, y = stream_cm_s
    return np.array([current_cm_s[0] * swing + x, current_cm_s[1] * swing + y, 0.0])


@kernel
def flow_near(pillars: Array, cells: RockCells, flow: Vector, p: Vector) -> Vector:
    """Velocity of the water at p, cm/s: the uniform `flow` and the sources of the solids near.

    The cells list the rocks within REACH_CM.

    Tu's source is v^s = a/(d - r)², outward from the axis of a pillar and below its top. Here a is
    the present strength of the uniform flow, which bounds v^s, and distances are in units of
    SOURCE_CM. Distances from a rock are those from its surface. All flow is level. The flows of
    rocks are weighted by their strength, so that the rocks of one stone act as one.
    """
    strength = np.sqrt(flow[0] * flow[0] + flow[1] * flow[1])
    if strength == 0.0:
        return flow
    sent, total = ZERO, 0.0
    for k in range(len(pillars)):
        x, y, radius, top = pillars[k]
        far = radius + FELT_CM
        if p[2] < top and abs(p[0] - x) < far and abs(p[1] - y) < far:
            way, gap = from_pillar((x, y, radius, np.inf), p)
            flow = plus(flow, times(_source(strength, gap), way))
    rocks = rocks_near(cells, p)
    for k in range(len(rocks)):
        far = rocks[k, WIDE] + REACH_CM
        aside = abs(p[0] - rocks[k, 0]) < far and abs(p[1] - rocks[k, 1]) < far
        if aside and is_felt(rocks[k], p):
            way, gap = from_turned_rock(rocks[k], rocks[k, COSINE], rocks[k, SINE], p)
            speed = _source(strength, gap)
            sent, total = plus(sent, times(speed * speed, (way[0], way[1], 0.0))), total + speed
    return plus(flow, times(1.0 / total, sent)) if total > 0.0 else flow


@kernel
def deflection_at(pillars: Array, cells: RockCells, p: Vector) -> Vector:
    """Velocity that the solids near p add to the current, over its speed, in any current."""
    return minus(flow_near(pillars, cells, EAST, p), EAST)


@kernel
def _source(strength: float, gap: float) -> float:
    """Speed of the water from a source, `gap` cm from its solid."""
    gap = gap / SOURCE_CM
    if gap > SPAN:
        return 0.0
    return strength / max(gap, 1.0) ** 2


@kernel
def set_drift(who: Ints, fishes: Fishes, sea: Sea, cells: RockCells, flow: Array) -> None:
    """Set `fishes.drift` to the velocity of the water at each of the fishes `who`."""
    uniform = vector(flow)
    for i in who:
        store(fishes.drift[i], flow_near(sea.pillars, cells, uniform, vector(fishes.position[i])))


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


@kernel
def shear_at(who: Ints, fishes: Fishes, sea: Sea, cells: RockCells, flow: Array) -> Array:
    """Velocity (k, 2, 3) of the water at the snouts and tails of the simulated fishes `who`, cm/s.

    It is relative to that at their origins, which carries them. -1 stands for nobody.
    """
    shear, uniform = np.zeros((len(who), 2, 3)), vector(flow)
    for k in range(len(who)):
        i = who[k]
        if i < 0 or not fishes.live[i]:
            continue
        middle, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
        radius = HULL_CM + BEAM_BL * float(fishes.length[i])
        water = _water_at(sea, cells, uniform, radius, middle)
        for tip in range(2):
            along = fishes.snout[i] - tip * fishes.length[i]
            there = _water_at(sea, cells, uniform, radius, plus(middle, times(along, ahead)))
            store(shear[k, tip], minus(there, water))
    return shear


@kernel
def _water_at(sea: Sea, cells: RockCells, flow: Vector, radius: float, p: Vector) -> Vector:
    """Velocity of the water at p, cm/s, with the wave of a hull of this radius."""
    hull, velocity = vector(sea.submarine[:3]), vector(sea.submarine[3:6])
    wave = bow_wave(minus(p, hull), velocity, radius)
    return plus(flow_near(sea.pillars, cells, flow, p), wave)
