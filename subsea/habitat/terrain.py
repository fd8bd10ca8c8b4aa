"""The seabed: a height field of dunes from a seed (SMC §6.2), with scour around solids.

Mounds of dead reef are in units of their radius: no point is farther than 1 from the axis, with the
summit at `HEIGHT`.
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.disk_cache import cached
from subsea.habitat.contact import clearances
from subsea.scenario.schema import Bounds, Scenario, Terrain

HEIGHT = 0.45
FOOT = 0.95  # radius of its foot
RADIUS_CM = 26.0, 68.0  # of the smallest and the largest
VARIANTS = 3  # forms of each kind of growth
ROUGH = 0.22  # relief, low enough that no knob is above the summit
LOBES = 0.12

_WAVES, _SHIFTS, _BENDS = [], [], []
for _rng in (np.random.default_rng([variant, 0x30D]) for variant in range(VARIANTS)):
    _turn = _rng.uniform(0.0, 2 * np.pi, 10)
    _number = 2 * np.pi / np.repeat([0.9, 0.6], 5)
    _WAVES.append(_number * np.stack([np.cos(_turn), np.sin(_turn)]))
    _SHIFTS.append(_rng.uniform(0.0, 2 * np.pi, 10))
    _BENDS.append(_rng.uniform(0.0, 2 * np.pi, 2))
_STRENGTH = np.repeat([1.0, 0.5], 5) / 3.2


def variant_of(own: Array) -> Ints:
    """Form (k,) of growths by their identity."""
    return np.asarray(own.astype(np.float32) * np.float32(7919.0) % VARIANTS).astype(np.int64)


def outline(variant: int, turn: Array) -> Array:
    """Distance of the edge (...) in each direction from the axis."""
    two, three = _BENDS[variant]
    bend = np.sin(2 * turn + two) + np.sin(3 * turn + three)
    return np.asarray(1.0 - 0.25 * LOBES * (2.0 - bend))


def dome(variant: int, flat: Array) -> Array:
    """Height (...) over places (..., 2); 0 beyond the edge."""
    out = np.hypot(flat[..., 0], flat[..., 1])
    out = out / outline(variant, np.arctan2(flat[..., 1], flat[..., 0]))
    rough = np.sin(flat @ _WAVES[variant] + _SHIFTS[variant]) @ _STRENGTH
    even = np.sqrt(np.maximum(1.0 - out * out, 0.0))
    return np.asarray(HEIGHT * even * (1.0 + ROUGH * out * out * rough))


SAMPLES = 193  # per side
MARGIN = 1.6  # half width of the grid over the world's radius, into the fog
WAVES = 28
RIM_CM = 120.0  # the seabed rises toward the rim, as in a bay
STEEP = 0.5  # rad by which the lee of a dune is ahead of a sine
# Small dunes, where the grid is fine enough: length, height, and least samples per length.
SMALL_CM, SMALL_HIGH_CM, SAMPLED = 140.0, 7.0, 4.5
# Around a solid the current digs a moat and heaps up a mound, mostly in the lee.
MOAT_CM, MOAT_WIDE_CM, MOUND_CM, MOUND_FAR_CM, MOUND_WIDE_CM = 6.0, 24.0, 11.0, 75.0, 50.0


def half_width(scenario: Scenario) -> float:
    """Half the side of the terrain's square, cm."""
    return MARGIN * scenario.bounds.radius_cm


def make_terrain(scenario: Scenario) -> Array:
    """Heights (n, n) float32, cm, row along y and column along x; mean near -depth_cm.

    A sum of waves in random directions, with amplitudes that fall with the wave number, bent by
    a slower one: long dunes with a steep lee and small ones on top; and a shelf beyond a slope. At
    most half the depth high.
    """
    return cached(_dunes, scenario.terrain, scenario.bounds)


def _dunes(terrain: Terrain, bounds: Bounds) -> Array:
    rng = np.random.default_rng([terrain.seed, 0x7E44A1])
    w = MARGIN * bounds.radius_cm
    axis = np.linspace(-w, w, SAMPLES)
    x, y = np.meshgrid(axis, axis)
    base = 2 * np.pi / terrain.dune_length_cm
    bend = 60.0 * np.sin(0.37 * base * y + rng.uniform(0, 2 * np.pi))
    heights = np.zeros_like(x)
    for octave in rng.uniform(-1.2, 1.3, WAVES):
        wave = base * 2.0**octave
        angle = rng.normal(0.5, 0.7)
        phase = rng.uniform(0, 2 * np.pi)
        along = (x + bend) * np.cos(angle) + y * np.sin(angle)
        heights += 2.0 ** (-1.7 * octave) * _dune(wave * along + phase)
    # A sine with this deviation has the height asked for.
    heights *= terrain.dune_height_cm / (8**0.5 * max(float(heights.std()), 1e-9))
    if SAMPLED * (axis[1] - axis[0]) < SMALL_CM and terrain.dune_height_cm > 0.0:
        patch = np.clip(0.5 + np.sin(0.61 * base * x + 2.0) * np.sin(0.83 * base * y), 0.0, 1.0)
        along = 0.9 * x + 0.45 * y + 0.4 * bend + 25.0 * np.sin(x / 171.0 - y / 233.0)
        heights += 0.5 * SMALL_HIGH_CM * patch * _dune(2 * np.pi / SMALL_CM * along)
    toward = np.radians(terrain.shelf_deg)
    away = x * np.cos(toward) + y * np.sin(toward) - terrain.shelf_at_cm
    risen = np.clip((away + 0.15 * bend) / terrain.slope_cm + 0.5, 0.0, 1.0)
    heights += terrain.shelf_cm * risen**2 * (3.0 - 2.0 * risen)
    rim = np.clip(np.hypot(x, y) / bounds.radius_cm - 0.75, 0.0, 1.0)
    heights = heights + RIM_CM * rim**2 - bounds.depth_cm
    return np.minimum(heights, -0.5 * bounds.depth_cm).astype(np.float32)


def _dune(phase: Array) -> Array:
    """A wave of height 2 whose lee is steep."""
    return np.asarray(np.sin(phase + STEEP * np.cos(phase)))


def drifted(
    heights: Array, half_width: float, pillars: Array, rocks: Array, current: tuple[float, float]
) -> Array:
    """The heights with a moat around the foot of each solid, and a mound beyond."""
    axis = np.linspace(-half_width, half_width, len(heights))
    x, y = np.meshgrid(axis, axis)
    reach = MOUND_FAR_CM + 2.5 * MOUND_WIDE_CM
    near = np.zeros(heights.shape, np.bool_)
    for rows, wide in ((pillars, pillars[:, 2]), (rocks, rocks[:, 3:5].max(axis=1, initial=0.0))):
        for (cx, cy), size in zip(rows[:, :2], wide, strict=True):
            near |= (np.abs(x - cx) < size + reach) & (np.abs(y - cy) < size + reach)
    if not near.any():
        return heights
    gap = np.full(heights.shape, 3.0 * reach)
    gap[near] = clearances(pillars, rocks, np.stack([x, y, heights], axis=2)[near].astype(float))
    slope_y, slope_x = np.gradient(np.minimum(gap, reach), axis, axis)
    way = np.array(current) / max(float(np.hypot(*current)), 1e-9)
    lee = np.clip(slope_x * way[0] + slope_y * way[1], -1.0, 1.0)
    moat = np.exp(-((np.maximum(gap - 10.0, 0.0) / MOAT_WIDE_CM) ** 2))
    mound = np.exp(-(((gap - MOUND_FAR_CM) / MOUND_WIDE_CM) ** 2)) * (0.55 + 0.45 * lee)
    return np.asarray(heights - MOAT_CM * moat + MOUND_CM * mound, np.float32)


def crest(heights: Array, half_width: float, radius: float) -> float:
    """The greatest height of the seabed within `radius`, cm."""
    axis = np.linspace(-half_width, half_width, len(heights))
    x, y = np.meshgrid(axis, axis)
    # A sample a cell beyond the radius still shapes the inside.
    inside = np.hypot(x, y) <= radius + 2.0 * (axis[1] - axis[0])
    return float(heights[inside].max())


def heights_at(heights: Array, half_width: float, places: Array) -> Array:
    """Heights (n,) at places (n, 2), bilinear as `geometry.height_field.height_at`."""
    last = len(heights) - 1
    at = np.clip((places + half_width) / (2 * half_width) * last, 0, last)
    (j, i) = cell = np.minimum(at.astype(int), last - 1).T
    u, v = at.T - cell
    south = (1 - u) * heights[i, j] + u * heights[i, j + 1]
    north = (1 - u) * heights[i + 1, j] + u * heights[i + 1, j + 1]
    return np.asarray((1 - v) * south + v * north, np.float64)
