"""Tileable textures, made at start: noise for the sand, caustics for the light."""

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

SIZE = 256


def tileable_noise(seed: int, size: int = SIZE, roughness: float = 1.6) -> Array:
    """Smooth noise (size, size) with mean 0 and deviation 1 whose edges meet.

    Random phases over a spectrum that falls with wave number to the power `roughness`.
    """
    rng = np.random.default_rng([seed, 0x401])
    k = np.fft.fftfreq(size) * size
    wave = np.hypot(k[:, None], k[None, :])
    wave[0, 0] = 1.0
    spectrum = wave**-roughness * np.exp(2j * np.pi * rng.uniform(size=(size, size)))
    spectrum[0, 0] = 0.0
    noise = np.fft.ifft2(spectrum).real
    return np.asarray(noise / noise.std())


def caustics(seed: int, size: int = SIZE) -> Array:
    """Brightness (size, size), mean 1, of light that a rippled surface focuses on the ground.

    A fine grid of vertical rays is bent by the slope of a tileable wave field and counted
    where it lands: bright lines are where neighbouring rays meet.
    """
    fine = 4 * size
    k = np.fft.fftfreq(size) * size
    wave = np.hypot(k[:, None], k[None, :])
    rng = np.random.default_rng([seed, 0xCA])
    band = np.exp(-(((wave - 7.0) / 3.5) ** 2)) * np.exp(2j * np.pi * rng.uniform(size=wave.shape))
    padded = np.zeros((fine, fine), complex)
    index = (np.fft.fftfreq(size) * size).astype(int)
    padded[np.ix_(index, index)] = band
    K = np.fft.fftfreq(fine) * fine
    slope_x = np.fft.ifft2(1j * K[None, :] * padded).real
    slope_y = np.fft.ifft2(1j * K[:, None] * padded).real
    # Strong enough that rays cross in places, so that the lines have their typical knots.
    reach = 0.021 * fine / max(float(slope_x.std()), 1e-12)
    grid = np.arange(fine)
    x = (grid[None, :] + reach * slope_x) % fine
    y = (grid[:, None] + reach * slope_y) % fine
    light, _, _ = np.histogram2d(y.ravel(), x.ravel(), bins=size, range=((0, fine), (0, fine)))
    spectrum = np.fft.fft2(light) * np.exp(-((wave / 70.0) ** 2))
    smooth = np.maximum(np.fft.ifft2(spectrum).real, 0.0)
    return np.asarray(smooth / smooth.mean())


def relief(seed: int, size: int = SIZE, cells: int = 24) -> list[Array]:
    """Stone that corals grew on, four tileable layers (size, size).

    Its height, about 0, with the slopes of that along x and y, per texel times `size`; and how
    near the middle of a polyp is, 0 to 1.
    """
    polyps = np.clip(1.0 - 1.4 * nearest_of_cells(seed, size, cells), 0.0, 1.0)
    rough = tileable_noise(seed + 1, size, 1.9)
    cracks = np.minimum(np.abs(tileable_noise(seed + 2, size, 2.2)), 0.45)
    grown = np.clip(0.5 + tileable_noise(seed + 3, size, 2.6), 0.0, 1.0)  # where polyps are
    height = 0.45 * rough + 1.1 * cracks + 0.45 * grown * polyps**0.7
    height -= height.mean()
    slope_x, slope_y = (
        size / 2 * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) for axis in (1, 0)
    )
    return [height, slope_x, slope_y, polyps]


def nearest_of_cells(seed: int, size: int, cells: int) -> Array:
    """Distance (size, size), in cells, to the nearest of one random point in each cell (Worley)."""
    rng = np.random.default_rng([seed, 0x33])
    points = rng.uniform(0.1, 0.9, (cells, cells, 2))
    at = (np.arange(size) + 0.5) * cells / size
    cell = at.astype(int)
    nearest = np.full((size, size), np.inf)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            row, column = cell + down, cell + right
            point = points[(row % cells)[:, None], (column % cells)[None, :]]
            y = (row[:, None] + point[..., 1]) - at[:, None]
            x = (column[None, :] + point[..., 0]) - at[None, :]
            nearest = np.minimum(nearest, np.hypot(x, y))
    return nearest


def upload(context: Any, layers: list[Array]) -> Any:
    """A repeating, mipmapped float texture of one to four layers (n, n)."""
    data = np.stack(layers, axis=-1).astype("f2")
    texture = context.texture(data.shape[1::-1], data.shape[2], data.tobytes(), dtype="f2")
    texture.build_mipmaps()
    # Reading two mipmaps for every sample would show little and take a sixth of a picture.
    texture.filter = moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR
    return texture
