"""Mounds of dead reef: the surface that is drawn and that growths stand on.

In units of the radius: no point is farther than 1 from the axis, with the summit at `HEIGHT`.
"""

import numpy as np

from subsea.base.arrays import Array, Ints

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
