"""Raster helpers for skin textures: blending, distance fields, noise and sRGB."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.fish.species import Colour
from subsea.fish.surface import Curve


def texels_around(outline: Curve, reach: float, s: Array, y: Array) -> tuple[slice, slice]:
    """Rows and columns of the texels within `reach` of an outline's bounding box."""
    low, high = np.min(outline, axis=0) - reach, np.max(outline, axis=0) + reach
    rows, columns = (
        np.searchsorted(y[:, 0], (low[1], high[1])),
        np.searchsorted(s, (low[0], high[0])),
    )
    return slice(*rows), slice(*columns)


def boxes_overlap(outline: Curve, s: Array, y: Array) -> bool:
    """True if the bounding boxes of an outline and of some points overlap."""
    low, high = np.min(outline, axis=0) - 0.02, np.max(outline, axis=0) + 0.02
    return bool(s.max() > low[0] and s.min() < high[0] and y.max() > low[1] and y.min() < high[1])


def depth_inside(outline: Curve, s: Array, y: Array) -> Array:
    """Signed distance (h, w) from a smooth outline, positive inside, body lengths.

    Computed at every fourth texel each way and interpolated.
    """
    coarse = depth_at(outline, every_fourth(s), every_fourth(y[:, 0])[:, None])
    return upsampled(upsampled(coarse.T, len(s)).T, len(y))


def depth_at(outline: Curve, x: Array, h: Array) -> Array:
    """Signed distance of any points from a smooth closed outline, positive inside."""
    corners = _rounded(np.asarray(outline, np.float32))
    shape = np.broadcast_shapes(x.shape, h.shape)
    inside = np.zeros(shape, bool)
    nearest = np.full(shape, np.inf, np.float32)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        dx, dy = bx - ax, by - ay
        t = (((x - ax) * dx + (h - ay) * dy) / max(dx * dx + dy * dy, 1e-12)).clip(0.0, 1.0)
        nearest = np.minimum(nearest, (x - ax - t * dx) ** 2 + (h - ay - t * dy) ** 2)
        if ay != by:
            inside ^= ((ay > h) != (by > h)) & (x < ax + dx * (h - ay) / dy)
    return np.where(inside, np.float32(1.0), np.float32(-1.0)) * np.sqrt(nearest)


def every_fourth(x: Array) -> Array:
    """Every fourth of evenly spaced numbers, extended beyond the last."""
    step = x[1] - x[0] if len(x) > 1 else 1.0
    return single(x[0] + 4 * step * np.arange(len(x) // 4 + 2)) if len(x) else x


def upsampled(values: Array, count: int) -> Array:
    """Rows (count, n) interpolated linearly from every fourth of them."""
    cell, t = np.divmod(np.arange(count), 4)
    share = single(t / 4)[:, None]
    return np.asarray(values[cell] + share * (values[cell + 1] - values[cell]))


def _rounded(corners: Array) -> Array:
    """Two rounds of Chaikin's corner cutting, which converges to the quadratic B-spline."""
    for _ in range(2):
        following = np.roll(corners, -1, axis=0)
        pair = np.stack([0.75 * corners + 0.25 * following, 0.25 * corners + 0.75 * following], 1)
        corners = pair.reshape(-1, 2)
    return corners


@cache
def cloud_noise() -> Array:
    """Tileable skin noise (256, 512) of deviation 1, the same for all species."""
    return _tile(lambda k: np.exp(-((k / 0.011) ** 2)))


@cache
def grain_noise() -> Array:
    """Finer noise of the same kind."""
    return _tile(lambda k: np.exp(-((k / 0.012) ** 2)) + 0.15 * np.exp(-((k / 0.1) ** 2)))


def _tile(share: Callable[[Array], Array]) -> Array:
    """Noise (256, 512) with a spectrum."""
    noise = np.random.default_rng(0x5C1).normal(size=(256, 512))
    k = np.hypot(np.fft.fftfreq(256)[:, None], np.fft.rfftfreq(512))
    smooth = np.fft.irfft2(np.fft.rfft2(noise) * share(k), s=(256, 512))
    return single(smooth / smooth.std())


def tiled(tile: Array, shape: tuple[int, ...]) -> Array:
    """Repeat a tile over (h, w)."""
    times = -(-shape[0] // tile.shape[0]), -(-shape[1] // tile.shape[1])
    return np.tile(tile, times)[: shape[0], : shape[1]]


def smoothstep(x: Array, low: float | Array, high: float | Array) -> Array:
    """0 at `low`, 1 at `high`, smooth between; `high` may be less than `low`."""
    return smooth_unit((x - low) / (high - low))


def smooth_unit(t: Array) -> Array:
    """0 below 0, 1 above 1, smooth between."""
    t = np.clip(t, 0.0, 1.0)
    smooth = 3.0 - 2.0 * t
    smooth *= t
    smooth *= t
    return np.asarray(smooth)


def blend(picture: Array, colour: Colour, share: Array) -> None:
    """Mix a colour into the planes by `share` (h, w), 0 to 1."""
    rows, columns = (np.flatnonzero(share.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    share = single(share[box])
    for plane, value in zip(picture, colour, strict=False):  # opacity stays
        under = plane[box]
        under += (np.float32(value) - under) * share


def single(values: Array) -> Array:
    """Convert to single precision, which is ample for eight bits and twice as fast."""
    return np.asarray(values, np.float32)


def to_srgb(linear: Array) -> Array:
    """Linear light, 0 to 1, to sRGB."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def from_srgb(value: Array) -> Array:
    """An sRGB colour, 0 to 1, to linear light."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def srgb_texels(picture: Array) -> NDArray[np.uint8]:
    """Planes (4, h, w) of linear light and opacity to sRGB texels (h, w, 4).

    A table of 4,096 steps suffices for eight bits.
    """
    table = np.round(255.0 * to_srgb(np.linspace(0.0, 1.0, 4097))).astype(np.uint8)
    texels = np.empty((*picture.shape[1:], 4), np.uint8)
    for k in range(3):
        steps = (np.float32(4096.0) * picture[k] + np.float32(0.5)).astype(np.int16)
        texels[..., k] = table.take(steps, mode="clip")
    texels[..., 3] = np.round(255.0 * picture[3].clip(0.0, 1.0))
    return texels
