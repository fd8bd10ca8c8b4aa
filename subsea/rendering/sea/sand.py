"""Tileable textures of sand: ripple marks, and litter of shells and coral."""

import numpy as np

from subsea.core.arrays import Array
from subsea.rendering.gl.mipmaps import Texels
from subsea.rendering.gl.textures import in_bytes, nearest_of_cells, tileable_noise

SIZE, FINE_SIZE = 384, 256
RIPPLES = 12  # mean number of ripples across a texture
CELLS = 26  # chips of litter across a texture

# Ranges of the bytes of the textures.
SPAN = np.array([3.0, 3.0, 3.0, 4.0])
LITTER_LOW, LITTER_HIGH = np.array([-3.5, -3.5, 0.0, 0.0]), np.array([3.5, 3.5, 1.0, 1.0])


def ripples(seed: int, size: int = SIZE) -> list[Array]:
    """Ripple marks with crests along y: slopes along x and y, height, grain; deviation 1.

    Band-limited noise wanders, forks and ends as ripples do; its phase is skewed, so that one side
    is steep, as from a current along x.
    """
    rng = np.random.default_rng([seed, 0x21])
    k = np.fft.fftfreq(size) * size
    along, across = k[None, :], k[:, None]
    # Both signs: one alone would be no wave but a phase.
    spectrum = np.exp(-(((along - RIPPLES) / 2.0) ** 2) - (across / 3.3) ** 2).astype(complex)
    spectrum *= np.exp(2j * np.pi * rng.uniform(size=(size, size)))
    wave = np.fft.ifft2(spectrum)
    strength, phase = np.abs(wave), np.angle(wave)
    strength = np.clip(strength / np.median(strength), 0.25, 1.3)
    skewed = phase + 0.55 * np.cos(phase)
    height = strength * (np.sin(skewed) + 0.22 * np.sin(2 * skewed - 0.6))
    height += 0.10 * tileable_noise(seed + 1, size, 1.6)
    grain = tileable_noise(seed + 2, size, 0.45)
    return [*_slopes(height), _even(height), grain]


def litter(seed: int) -> list[Array]:
    """Chips of shell and coral: slopes along x and y, tone, and frequency (0 between chips)."""
    x, y, which = nearest_of_cells(seed, FINE_SIZE, CELLS)
    rng = np.random.default_rng([seed, 0x11])
    tone, common, turn, long, wide = rng.uniform(size=(5, CELLS * CELLS))[:, which]
    # Chips at random angles, some long, with irregular outlines.
    rough = [0.09 * tileable_noise(seed + k, FINE_SIZE, 1.5) for k in (1, 2)]
    c, s = np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)
    u = (c * x + s * y + rough[0]) * (1.0 + 1.4 * long)
    v = c * y - s * x + rough[1]
    away = np.maximum(np.hypot(u, v), 0.8 * (np.abs(u) + np.abs(v)))
    inside = np.clip((0.16 + 0.32 * wide**1.5 - away) / 0.05, 0.0, 1.0)
    bulge = inside * (1.0 + 1.2 * (tone - 0.5) * (u + v))
    return [*_slopes(bulge), tone, common * inside]


def rippled(seed: int) -> Texels:
    """Ripple marks as a texture."""
    return in_bytes(ripples(seed), -SPAN, SPAN)


def littered(seed: int) -> Texels:
    """Litter as a texture."""
    return in_bytes(litter(seed), LITTER_LOW, LITTER_HIGH)


def _slopes(height: Array) -> tuple[Array, Array]:
    """Slopes along x and y with a joint deviation of 1."""
    x, y = (np.roll(height, -1, axis) - np.roll(height, 1, axis) for axis in (1, 0))
    size = float(np.sqrt((x**2 + y**2).mean()))
    return x / size, y / size


def _even(values: Array) -> Array:
    return np.asarray((values - values.mean()) / values.std())
