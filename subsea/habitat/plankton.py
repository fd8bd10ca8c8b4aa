"""Plankton carried by the current, and bubbles that leave vents in the seabed (Tu §8.2)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.noise import uniform
from subsea.geometry.solids import height_at, is_over_all
from subsea.geometry.vector import Vector, norm, plus, store, times, vector
from subsea.habitat.contact import is_free
from subsea.habitat.current import deflection_at
from subsea.habitat.rocks import RockCells, rocks_near
from subsea.kernels import kernel
from subsea.state import Clock, Sea

SLOWEST = 0.22  # least diameter over a vent's largest, as in `bubbles.vert`
BURST = 9.0  # bubbles that leave together
STAGGER_S = 0.37  # from vent to vent


def terminal_speed(diameter: Array | float) -> Array:
    """Terminal speed in cm/s of bubbles with a diameter in cm (Mendelson 1967)."""
    wave = np.sqrt(154.0 / np.asarray(diameter) + 495.0 * np.asarray(diameter))
    return np.asarray(np.minimum(wave, 280.0 * np.asarray(diameter)))


def departures(depth_cm: float, rate: float, size: float, number: int) -> tuple[Array, float]:
    """First moments (n,), s, at which bubbles leave vent `number`, and the time until they repeat.

    The vent emits `rate` bubbles a second, of at most `size` cm, in bursts. There are as many
    moments as bubbles that rise at one time: all have gone when the moments repeat.
    """
    diameters = size * np.linspace(SLOWEST, 1.0, 50)
    slowest_s = depth_cm / float(terminal_speed(diameters).min()) + 1.0
    count = int(np.ceil(rate * slowest_s))
    k = np.arange(count)
    moments = (k + 0.85 * BURST / (2 * np.pi) * np.sin(2 * np.pi * k / BURST)) / rate
    return moments + STAGGER_S * number, count / rate


WANDER_CM_S = 4.0  # size of a speck's own random motion
HOLD_TICKS = 45  # how long a speck keeps its random direction
FEEL_TICKS = 8  # from one look at the solids near a speck to the next: it drifts a few cm
SINK_CM_S, SINKS_S = 4.0, 25.0  # how fast and how long food from the submarine sinks
CLEARANCE_CM = 12.0  # from the seabed and from the surface
RETURN_CM, RETURN_HEIGHT_CM = 200.0, 100.0  # range around its end in which a speck returns
# Keys of the random numbers.
WANDER_X, WANDER_Y, WANDER_Z, RETURN_ANGLE, RETURN_SHARE, RETURN_DISTANCE = (
    np.int64(key) for key in (100, 101, 102, 110, 111, 112)
)
TRIES = 100  # attempts before a speck is left in a solid
HUGE_CM = 120.0  # least half axis of a huge solid
NO_PILLARS, NO_ROCKS = np.zeros((0, 4)), np.zeros((0, 7))


def scatter(
    rng: np.random.Generator,
    number: int,
    radius: float,
    heights: Array,
    half_width: float,
    pillars: Array = NO_PILLARS,
    rocks: Array = NO_ROCKS,
) -> Array:
    """Places (p, 3) float32, cm: even over the cylinder's area and the water's height.

    None lies in a solid, unless solids fill the sea. Each speck that does tries again with random
    numbers of its own, so that moving a stone moves only the specks there. Those in a huge solid
    take them from `rng`, on which the worlds of open water rest since their first record.
    """
    huge = pillars[pillars[:, 2] >= HUGE_CM], rocks[(rocks[:, 3:6] >= HUGE_CM).all(axis=1)]
    angle = rng.uniform(0, 2 * np.pi, number)
    distance = radius * np.sqrt(rng.uniform(0, 1, number))
    share = rng.uniform(0, 1, number)
    places = np.zeros((number, 3), np.float32)
    for k in range(number):
        for attempt in range(TRIES):
            x, y = distance[k] * np.cos(angle[k]), distance[k] * np.sin(angle[k])
            floor = height_at(heights, half_width, x, y) + CLEARANCE_CM
            places[k] = x, y, floor + share[k] * (-CLEARANCE_CM - floor)
            if is_free(pillars, rocks, vector(places[k])):
                break
            again = np.random.default_rng([int(share[k] * 2**53), attempt])
            if not is_free(*huge, vector(places[k])):
                again = rng
            angle[k], share[k] = again.uniform(0, 2 * np.pi), again.uniform(0, 1)
            distance[k] = radius * np.sqrt(again.uniform(0, 1))
    return places


@kernel
def drift(who: Ints, sea: Sea, cells: RockCells, flow: Array, clock: Clock) -> None:
    """Move the specks `who` by one tick with the water, and a little at random.

    A speck that leaves the cylinder enters on the other side. One that was eaten returns after its
    absence near the same place: the oscillating current brings nothing from afar, and feeding
    grounds would be empty in half an hour. Food from the submarine sinks for a while. Specks do
    not enter solids, which they look for in turns.
    """
    uniform_flow = vector(flow)
    speed = norm(uniform_flow)
    for k in who:
        if sea.absent[k] > 0.0:
            sea.absent[k] = max(sea.absent[k] - np.float32(clock.dt), np.float32(0.0))
            if sea.absent[k] == 0.0:
                entry = _return(sea, k, clock)
                inside = np.hypot(entry[0], entry[1]) < sea.radius
                if inside and is_free(sea.pillars, sea.rocks, entry):
                    store(sea.plankton[k], entry)
                else:
                    sea.absent[k] = clock.dt  # try again in the next tick
            continue
        epoch = (clock.tick + k) // HOLD_TICKS
        own = (
            WANDER_CM_S * (2.0 * uniform(clock.seed, k, epoch, WANDER_X) - 1.0),
            WANDER_CM_S * (2.0 * uniform(clock.seed, k, epoch, WANDER_Y) - 1.0),
            WANDER_CM_S * (2.0 * uniform(clock.seed, k, epoch, WANDER_Z) - 1.0),
        )
        if sea.absent[k] < 0.0:
            sea.absent[k] = min(sea.absent[k] + np.float32(clock.dt), np.float32(0.0))
            own = (own[0], own[1], own[2] - SINK_CM_S)
        here = vector(sea.plankton[k])
        if clock.tick == 0 or (clock.tick + k) % FEEL_TICKS == 0:
            aside = deflection_at(sea.pillars, cells, here)
            sea.deflection[k, 0], sea.deflection[k, 1] = aside[0], aside[1]
        aside = (float(sea.deflection[k, 0]), float(sea.deflection[k, 1]), 0.0)
        velocity = plus(plus(uniform_flow, times(speed, aside)), own)
        x, y, z = plus(here, times(clock.dt, velocity))
        if x * x + y * y > sea.radius * sea.radius:
            x, y = -0.98 * x, -0.98 * y
        floor = height_at(sea.floor, sea.half_width, x, y) + CLEARANCE_CM
        there = (x, y, min(max(z, floor), -CLEARANCE_CM))
        if not is_over_all(sea.skyline, sea.half_width, there, 0.0):
            # A speck drawn into a solid by a mouth may leave it.
            rocks = rocks_near(cells, there)
            if not is_free(sea.pillars, rocks, there) and is_free(sea.pillars, rocks, here):
                continue
        store(sea.plankton[k], there)


@kernel
def _return(sea: Sea, k: int, clock: Clock) -> Vector:
    """A place in the water near where speck k was eaten."""
    angle = 2.0 * np.pi * uniform(clock.seed, k, clock.tick, RETURN_ANGLE)
    share = uniform(clock.seed, k, clock.tick, RETURN_SHARE)
    distance = RETURN_CM * np.sqrt(uniform(clock.seed, k, clock.tick, RETURN_DISTANCE))
    x = sea.plankton[k, 0] + distance * np.cos(angle)
    y = sea.plankton[k, 1] + distance * np.sin(angle)
    floor = height_at(sea.floor, sea.half_width, x, y) + CLEARANCE_CM
    low = max(sea.plankton[k, 2] - RETURN_HEIGHT_CM, floor)
    high = max(min(sea.plankton[k, 2] + RETURN_HEIGHT_CM, -CLEARANCE_CM), low)
    return x, y, min(low + share * (high - low), -CLEARANCE_CM)
