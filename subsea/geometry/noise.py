"""Smooth noise in space, and random numbers from keys: the same on every machine and thread."""

import math

import numpy as np
from numba import uint64

from subsea.kernels import kernel


@kernel
def uniform(seed: int, fish: int, tick: int, purpose: int) -> float:
    """A number in [0, 1) that depends only on the four keys (SplitMix64 finaliser).

    A constant `purpose` is an np.int64; numba would compile this again for each plain one.
    """
    z = uint64(seed) * uint64(0x9E3779B97F4A7C15)
    for key in (fish, tick, purpose):
        z = (z ^ uint64(key)) + uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB)
        z = z ^ (z >> uint64(31))
    return np.float64(z >> uint64(11)) * 2.0**-53


@kernel
def noise(x: float, y: float, z: float) -> float:
    """Gradient noise (Perlin 2002) around 0, seldom beyond ±0.7, of wavelength about 1.5."""
    fx, fy, fz = math.floor(x), math.floor(y), math.floor(z)
    i, j, k = int(fx), int(fy), int(fz)
    x, y, z = x - fx, y - fy, z - fz
    u, v, w = _eased(x), _eased(y), _eased(z)
    low = _mix(
        v,
        _mix(u, _corner(i, j, k, x, y, z), _corner(i + 1, j, k, x - 1.0, y, z)),
        _mix(u, _corner(i, j + 1, k, x, y - 1.0, z), _corner(i + 1, j + 1, k, x - 1.0, y - 1.0, z)),
    )
    k, z = k + 1, z - 1.0
    high = _mix(
        v,
        _mix(u, _corner(i, j, k, x, y, z), _corner(i + 1, j, k, x - 1.0, y, z)),
        _mix(u, _corner(i, j + 1, k, x, y - 1.0, z), _corner(i + 1, j + 1, k, x - 1.0, y - 1.0, z)),
    )
    return _mix(w, low, high)


@kernel
def fractal(x: float, y: float, z: float, octaves: int) -> float:
    """Noise summed over octaves, each half as long and half as strong; about ±0.8."""
    total, share = 0.0, 1.0
    for _ in range(octaves):
        total += share * noise(x, y, z)
        x, y, z, share = 2.03 * x + 17.3, 2.03 * y - 5.1, 2.03 * z + 9.7, 0.5 * share
    return total


@kernel
def _eased(t: float) -> float:
    return t * t * t * (t * (6.0 * t - 15.0) + 10.0)


@kernel
def _mix(share: float, a: float, b: float) -> float:
    return a + share * (b - a)


@kernel
def _corner(i: int, j: int, k: int, x: float, y: float, z: float) -> float:
    """The hashed gradient of a lattice corner times the offset from it."""
    h = (i * 374761393 + j * 668265263 + k * 1440662683) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    h = h ^ (h >> 16)
    gx, gy, gz = (h & 1023) - 511.5, ((h >> 10) & 1023) - 511.5, ((h >> 20) & 1023) - 511.5
    return (gx * x + gy * y + gz * z) / 420.0
