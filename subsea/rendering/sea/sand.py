"""Tileable textures of sand: ripple marks, litter of shells and coral, and tracks of animals."""

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.gl.textures import Texels, in_bytes, nearest_of_cells, tileable_noise

SIZE, FINE_SIZE = 384, 512
RIPPLES = 12  # mean number of ripples across a texture
CELLS = 26  # chips of litter across a texture
SHELLS = 0.3  # share of chips that are whole shells
RIBS = 11  # of a shell, on half a turn about its hinge
TRAILS, STEPS = 11, 210  # on a texture of tracks; steps of two texels that each is long
WIDE = 3.2  # half width of a trail, texels

# Ranges of the bytes of the textures.
SPAN = np.array([3.0, 3.0, 3.0, 4.0])
TRACK_SPAN = np.array([9.0, 9.0, 2.0, 1.0])
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
    size = 0.16 + 0.32 * wide**1.5
    inside = np.clip((size - away) / 0.05, 0.0, 1.0)
    bulge = inside * (1.0 + 1.2 * (tone - 0.5) * (u + v))
    # Shells are fans with ribs about a hinge.
    shell = np.modf(17.0 * common)[0] < SHELLS
    u, v = c * x + s * y + 0.6 * size, c * y - s * x
    far, turn = np.hypot(u, v), np.arctan2(v, u)
    fan = np.clip((1.25 * size * np.cos(0.75 * turn) - far) / 0.04, 0.0, 1.0)
    fan *= np.abs(turn) < 1.4
    ribbed = fan * (1.15 - 0.6 * far / size) * (1.0 + 0.16 * np.cos(2 * RIBS * turn))
    inside, bulge = np.where(shell, fan, inside), np.where(shell, ribbed, bulge)
    tone = np.where(shell, 0.6 + 0.4 * tone, tone)
    return [*_slopes(bulge), tone, common * inside]


def tracks(seed: int) -> list[Array]:
    """Trails of snails, worms and crabs: slopes along x and y, deviation 1, height, and 0.

    Snails plough a furrow between two walls, worms leave a ridge, crabs two rows of holes.
    """
    rng = np.random.default_rng([seed, 0x7A])
    height = np.zeros((FINE_SIZE, FINE_SIZE))
    reach = int(4 * WIDE)
    box = np.arange(-reach, reach + 1)
    for trail in range(TRAILS):
        along, start, *bends = np.arange(STEPS), *rng.uniform(0.0, 2 * np.pi, 4)
        turn = start + 0.9 * np.sin(along / 31.0 + bends[0]) + 0.5 * np.sin(along / 13.0 + bends[1])
        turn += 0.012 * (bends[2] - np.pi) * along
        way = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        path = rng.uniform(0.0, FINE_SIZE, 2) + np.cumsum(2.0 * way, axis=0)
        distance = np.full_like(height, np.inf)
        crab, wide = trail % 3 == 2, WIDE * rng.uniform(0.6, 1.1)
        if crab:
            left = np.where(along // 2 % 2 == 0, 1.0, -1.0)[:, None]
            path = (path + left * 1.5 * wide * way[:, ::-1] * (-1.0, 1.0))[::2]
        for column, row in path:
            i, j = int(row), int(column)
            away = np.hypot((i + box - row)[:, None], (j + box - column)[None, :])
            at = np.ix_((i + box) % FINE_SIZE, (j + box) % FINE_SIZE)
            distance[at] = np.minimum(distance[at], away)
        d = distance / wide
        wall = 0.6 * np.exp(-(((d - 1.5) / 0.5) ** 2))
        profile = np.exp(-(d**2)) if trail % 3 == 1 else wall - np.exp(-(d**2))
        if crab:
            profile = 0.5 * wall - 0.9 * np.exp(-((d / 0.7) ** 2))
        height += np.where(np.abs(profile) > np.abs(height), profile - height, 0.0)
    return [*_slopes(height), height, np.zeros_like(height)]


def rippled(seed: int) -> Texels:
    """Ripple marks as a texture."""
    return in_bytes(ripples(seed), -SPAN, SPAN)


def tracked(seed: int) -> Texels:
    """Tracks as a texture."""
    return in_bytes(tracks(seed), -TRACK_SPAN, TRACK_SPAN)


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
