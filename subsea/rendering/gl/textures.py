"""Tileable textures: noise, caustics, waves and the relief of stone; mipmaps and cached texels."""

from collections.abc import Callable
from itertools import product
from typing import Any, ParamSpec

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bytes, Ints
from subsea.base.disk_cache import cached

P = ParamSpec("P")
Texels = NDArray[Any]  # bytes, half or single floats (h, w, c), bottom row first

# OpenGL enums of formats by the number of planes.
HALVES, BYTES = (0x822D, 0x822F, 0x881B, 0x881A), (0x8229, 0x822B, 0x8051, 0x8058)
SRGB8_ALPHA8 = 0x8C43  # for colours in sRGB
ALL = 1000  # levels: down to one texel


def mipmapped(context: Any, texels: Texels, last: int = ALL, srgb: bool = False) -> Any:
    """Make a texture with mipmaps up to level `last`."""
    texture = _plain(context, texels, srgb)
    texture.build_mipmaps(max_level=last)
    return texture


def upload(context: Any, texels: Texels) -> Any:
    """Make a texture whose edge extends outward, of texels (h, w, c), bottom row first."""
    texture = _plain(context, texels)
    texture.repeat_x = texture.repeat_y = False
    return texture


def table(context: Any, values: Array) -> Any:
    """Make a texture of `values` (rows, columns, 4) that shaders fetch by index."""
    texture = _plain(context, values)
    texture.filter = context.NEAREST, context.NEAREST
    return texture


def cached_texture(
    context: Any,
    last: int,
    srgb: bool,
    make: Callable[P, Texels],
    *given: P.args,
    **named: P.kwargs,
) -> Any:
    """As `mipmapped`, of `make(*given, **named)`, whose texels are cached on disk."""
    return mipmapped(context, cached(make, *given, **named), last, srgb)


def _plain(context: Any, texels: Texels, srgb: bool = False) -> Any:
    (height, width, planes), kind = texels.shape, {1: "f1", 2: "f2", 4: "f4"}[texels.itemsize]
    return context.texture(
        (width, height), planes, np.ascontiguousarray(texels), dtype=kind, alignment=1,
        internal_format=None if kind == "f4" else _format(texels, srgb),
    )  # fmt: skip


def _format(texels: Texels, srgb: bool) -> int:
    formats = BYTES if texels.dtype == np.uint8 else HALVES
    return SRGB8_ALPHA8 if srgb else formats[texels.shape[2] - 1]


SIZE = 256
WIND = 0.6  # rad, main direction of the waves


def tileable_noise(seed: int, size: int = SIZE, roughness: float = 1.6) -> Array:
    """Tileable noise (size, size) with mean 0 and deviation 1.

    Random phases over a spectrum that falls with the wave number to the power `roughness`.
    """
    rng = np.random.default_rng([seed, 0x401])
    k = np.fft.fftfreq(size) * size
    wave = np.hypot(k[:, None], k[None, :])
    wave[0, 0] = 1.0
    spectrum = wave**-roughness * np.exp(2j * np.pi * rng.uniform(size=(size, size)))
    spectrum[0, 0] = 0.0
    noise = np.fft.ifft2(spectrum).real
    return np.asarray(noise / noise.std())


def caustics(
    seed: int,
    size: int = SIZE,
    waves: tuple[float, float] = (4.0, 24.0),
    reach: float = 0.020,
    penumbra: float = 0.0035,
) -> Array:
    """Brightness (size, size), mean 1, of light that a wavy surface focuses on the ground.

    A grid of vertical rays is refracted by the slopes of a tileable wave field and counted where it
    lands. `waves` are the numbers of the longest and shortest waves in the tile, `reach` is the
    displacement of a ray of mean slope and `penumbra` the blur by the sun's disc, as shares of the
    tile.
    """
    fine = 2 * size
    n = np.fft.fftfreq(size) * size
    wave = np.hypot(n[:, None], n[None, :])
    wave[0, 0] = 1.0
    rng = np.random.default_rng([seed, 0xCA])
    along = np.cos(np.arctan2(n[:, None], n[None, :]) - WIND) ** 2
    slope = np.where(wave < waves[0], (wave / waves[0]) ** 2, waves[0] / wave) * (
        0.25 + 0.75 * along
    )
    band = slope * np.exp(-((wave / waves[1]) ** 2) + 2j * np.pi * rng.uniform(size=wave.shape))
    slopes = []
    for share in (n[None, :] / wave, n[:, None] / wave):
        padded = np.zeros((fine, fine), complex)
        padded[np.ix_(n.astype(int), n.astype(int))] = 1j * share * band
        slopes.append(np.fft.ifft2(padded).real)
    mean = np.sqrt((slopes[0] ** 2 + slopes[1] ** 2).mean())
    grid = np.arange(fine) * size / fine
    x = grid[None, :] + reach * size / mean * slopes[0]
    y = grid[:, None] + reach * size / mean * slopes[1]
    blur = np.exp(-2.0 * (np.pi * penumbra * wave) ** 2)
    light = np.maximum(np.fft.ifft2(np.fft.fft2(_gathered(x, y, size)) * blur).real, 0.0)
    return np.asarray(light / light.mean())


def _gathered(x: Array, y: Array, size: int) -> Array:
    """Points per texel (size, size), each split among the nearest four texels."""
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right, down = x - column, y - row
    out = np.zeros(size * size)
    for i, share_y in ((0, 1.0 - down), (1, down)):
        for j, share_x in ((0, 1.0 - right), (1, right)):
            texel = (row + i) % size * size + (column + j) % size
            out += np.bincount(texel.ravel(), (share_y * share_x).ravel(), size * size)
    return out.reshape(size, size)


def ripples(seed: int, size: int = SIZE) -> list[Array]:
    """Slopes of a windy surface along x and y, each (size, size), tileable, deviation 1.

    The mean square slope falls slowly with the wave number (Cox and Munk).
    """
    rng = np.random.default_rng([seed, 0x51])
    n = np.fft.fftfreq(size) * size
    wave = np.hypot(n[:, None], n[None, :])
    wave[0, 0] = 1.0
    along = np.cos(np.arctan2(n[:, None], n[None, :]) - WIND) ** 2
    slope = wave**-1.35 * (1.0 - np.exp(-((wave / 3.0) ** 2))) * (0.3 + 0.7 * along)
    slope = slope * np.exp(2j * np.pi * rng.uniform(size=wave.shape))
    both = [
        np.fft.ifft2(1j * share * slope).real for share in (n[None, :] / wave, n[:, None] / wave)
    ]
    mean = np.sqrt((both[0] ** 2 + both[1] ** 2).mean() / 2)
    return [both[0] / mean, both[1] / mean]


def relief(seed: int, size: int = SIZE) -> list[Array]:
    """Relief of encrusted stone in four tileable layers (size, size).

    Height with mean 0; its slopes along x and y, per texel times `size`; nearness of the middle of
    a polyp, 0 to 1.
    """
    polyps = np.clip(1.0 - 1.4 * cell_distance(seed, size, 24), 0.0, 1.0)
    rough = tileable_noise(seed + 1, size, 1.9)
    cracks = np.minimum(np.abs(tileable_noise(seed + 2, size, 2.2)), 0.45)
    grown = np.clip(0.9 * tileable_noise(seed + 3, size, 2.2) - 0.1, 0.0, 1.0)  # where polyps are
    height = 0.45 * rough + 1.1 * cracks + 0.45 * grown * polyps**0.7
    height -= height.mean()
    slope_x, slope_y = (
        size / 2 * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) for axis in (1, 0)
    )
    return [height, slope_x, slope_y, polyps]


def nearest_of_cells(seed: int, size: int, cells: int) -> tuple[Array, Array, Ints]:
    """Offsets along x and y from the nearest of one random point per cell, and its index (Worley).

    All are (size, size); offsets are in cells.
    """
    rng = np.random.default_rng([seed, 0x33])
    points = rng.uniform(0.1, 0.9, (cells * cells, 2))
    at = (np.arange(size) + 0.5) * cells / size
    cell = at.astype(int)
    nearest, owner = np.full((size, size), np.inf), np.zeros((size, size), np.int64)
    way_x, way_y = np.zeros((size, size)), np.zeros((size, size))
    for down, right in product((-1, 0, 1), repeat=2):
        row, column = cell + down, cell + right
        which = (row % cells)[:, None] * cells + (column % cells)[None, :]
        y = (at - row)[:, None] - points[which, 1]
        x = (at - column)[None, :] - points[which, 0]
        away = x * x + y * y
        closer = away < nearest
        nearest[closer], owner[closer] = away[closer], which[closer]
        way_x[closer], way_y[closer] = x[closer], y[closer]
    return way_x, way_y, owner


def cell_distance(seed: int, size: int, cells: int) -> Array:
    """Distance (size, size) from the nearest of one random point per cell, in cells."""
    return np.hypot(*nearest_of_cells(seed, size, cells)[:2])


def halves(layers: list[Array]) -> Texels:
    """One to four layers (n, n) as half floats."""
    return np.stack(layers, axis=-1).astype(np.float16)


def next_mipmap(layer: Array) -> Array:
    """The means (n/2, n/2) of squares of four texels of a layer (n, n): its next mipmap."""
    n = len(layer) // 2
    return np.asarray(layer.reshape(n, 2, n, 2).mean(axis=(1, 3)))


def in_bytes(layers: list[Array], low: Array, high: Array) -> Texels:
    """Layers (n, n) as bytes that span `low` to `high`."""
    data = np.clip((np.stack(layers, axis=-1) - low) / (np.asarray(high) - low), 0.0, 1.0)
    return (255.0 * data + 0.5).astype(np.uint8)


def near_and_far(seed: int) -> Texels:
    """Caustics near the surface, of short waves, and far below, of long waves, blurred."""
    return halves([caustics(seed), caustics(seed, waves=(4.0, 14.0), reach=0.040, penumbra=0.010)])


def noise(seed: int) -> Texels:
    """Noise as a texture."""
    return halves([tileable_noise(seed)])


# Trilinear filtering would show little and take a sixth of the time of a picture.
ONE_LEVEL = moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR


def repeating(context: Any, make: Callable[[int], Texels], seed: int) -> Any:
    """A repeating texture of `make(seed)`, cached on disk."""
    texture = cached_texture(context, ALL, False, make, seed)
    texture.filter = ONE_LEVEL
    return texture


def repeating_levels(context: Any, make: Callable[[int], list[Texels]], seed: int) -> Any:
    """A repeating texture whose mipmaps are `make(seed)`, largest first, cached on disk."""
    levels = cached(make, seed)
    texture = _plain(context, levels[0])
    texture.build_mipmaps(max_level=len(levels) - 1)
    for level, texels in enumerate(levels[1:], 1):
        texture.write(texels, level=level, alignment=1)
    texture.filter = ONE_LEVEL
    return texture


class ImageTexture:
    """A picture on the GPU; `glo` is its OpenGL name, which panels need."""

    def __init__(self, context: Any, pixels: Bytes) -> None:
        """Upload pixels (h, w, 3 or 4), top row first, halved until the GPU can hold them."""
        most = context.info["GL_MAX_TEXTURE_SIZE"]
        while max(pixels.shape[:2]) > most:
            pixels = pixels[::2, ::2]
        self._texture = upload(context, pixels)
        self._texture.build_mipmaps()
        self._texture.filter = context.LINEAR_MIPMAP_LINEAR, context.LINEAR
        self.glo: int = self._texture.glo

    def release(self) -> None:
        """Free the texture; no panel may show it any more."""
        self._texture.release()
