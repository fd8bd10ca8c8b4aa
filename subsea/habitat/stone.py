"""Light and growth on stone: its share of the sky's light, and evenly spread sites for corals."""

import math
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.vector import Vector, dot, plus, times, vector
from subsea.habitat.formations import (
    numbered_formations,
    on_the_surface,
    rough_distance,
    stone_keys,
)
from subsea.kernels import kernel

SUN = (0.28, 0.17, 0.945)  # toward it at noon, below the surface
WATER_INDEX = 1.33
# Directions of the upper half of the sky, even in the light that they give to level ground.
SKY = np.array(
    [(0.0, 0.0, 1.0)]
    + [(0.62 * math.cos(t), 0.62 * math.sin(t), 0.785) for t in np.arange(4) * math.pi / 2 + 0.4]
    + [(0.91 * math.cos(t), 0.91 * math.sin(t), 0.415) for t in np.arange(5) * math.pi * 0.4]
)


class Shade(NamedTuple):
    """Distances from a formation on a grid, for tracing light."""

    field: Array  # (a, b, c) cm
    corner: Array  # (3,) cm
    cell: float  # cm
    reach: float  # cm, beyond which it blocks little of the sky's light


TWILIGHT, MOONRISE = 0.25, 0.5  # depth of the sun over its height at noon: dark, moon is up


def sun_at(hour: float) -> tuple[Vector, float]:
    """Direction toward the light below the surface, and the sine of the sun's height above it.

    In the air the sun moves on a great circle, from the horizon at 6 through noon to that at 18.
    After sunset the light comes from ever higher in the twilight sky, then from a full moon, which
    stands opposite the sun.
    """
    flat = math.hypot(SUN[0], SUN[1])
    aside = WATER_INDEX * flat  # Snell's law
    high = math.sqrt(1.0 - aside**2)
    turn = math.pi * (hour - 6.0) / 12.0
    along, across = math.sin(turn) * aside, math.cos(turn)
    ax, ay = SUN[0] / flat, SUN[1] / flat
    x = (along * ax + across * ay) / WATER_INDEX
    y = (along * ay - across * ax) / WATER_INDEX
    if math.sin(turn) < 0.0:
        dark, moon = night_at(hour)
        x, y = (1.0 - dark - moon) * x, (1.0 - dark - moon) * y
    return (x, y, math.sqrt(1.0 - x * x - y * y)), math.sin(turn) * high


SUNS = 8  # directions of the sun for which the shade of a moving day is known
NO_SUNS = np.zeros((0, 3))


def suns_of_day(moving: bool = True) -> Array:
    """Compute directions (SUNS, 3) toward the sun, even along its course from east to west.

    Without a `moving` sun there are none.
    """
    if not moving:
        return NO_SUNS
    across = np.linspace(1.0, -1.0, SUNS)
    return np.array([sun_at(6.0 + 12.0 / math.pi * math.acos(one))[0] for one in across])


def shares_of_suns(sun: Array) -> Array:
    """Compute the shares (SUNS,) of `suns_of_day` in the shade of a `sun` between two of them.

    The moon takes the course of the sun.
    """
    flat = math.hypot(SUN[0], SUN[1])
    across = WATER_INDEX * float(sun[0] * SUN[1] - sun[1] * SUN[0]) / flat
    place = 0.5 * (1.0 - across) * (SUNS - 1)
    return np.asarray(np.maximum(1.0 - np.abs(np.arange(SUNS) - place), 0.0))


def night_at(hour: float) -> tuple[float, float]:
    """Compute how dark the sky is at an hour, and how much of the moon's light there is, 0 to 1.

    Both are 0 from 6 to 18 h. The sky is dark an hour later; then the moon grows bright.
    """
    deep = max(-math.sin(math.pi * (hour - 6.0) / 12.0), 0.0)
    dark, moon = deep / TWILIGHT, (deep - TWILIGHT) / (MOONRISE - TWILIGHT)
    return _eased(dark), _eased(moon)


def _eased(share: float) -> float:
    """Ease a share from 0 to 1, which it is held to."""
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


def box_of(blocks: Array) -> tuple[Array, Array]:
    """Lowest and highest corner (3,) of what fishes avoid; pillars have no lower end."""
    long = np.maximum(blocks[:, 3], blocks[:, 4])
    reach = np.stack([long, long, blocks[:, 5]], axis=1)
    rise = np.where(np.isinf(reach), 0.0, reach)
    return (blocks[:, :3] - reach).min(axis=0), (blocks[:, :3] + rise).max(axis=0)


def shade_of(blocks: Array) -> Shade:
    """The grid of a formation."""
    low, high = box_of(blocks)
    low[2] = max(low[2], high[2] - 1200.0)
    cell = float(np.clip((high - low).max() / 44.0, 8.0, 26.0))
    low, high = low - 2.0 * cell, high + 2.0 * cell
    number = np.ceil((high - low) / cell).astype(int) + 1
    reach = max(0.4 * float((high - low).max()), 100.0)
    return Shade(_rough_grid(blocks, low, cell, *number), low, cell, reach)


@kernel
def _rough_grid(blocks: Array, corner: Array, cell: float, nx: int, ny: int, nz: int) -> Array:
    out = np.empty((nx, ny, nz))
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                p = (corner[0] + cell * i, corner[1] + cell * j, corner[2] + cell * k)
                out[i, j, k] = rough_distance(blocks, p)
    return out


@kernel
def shade_distance(shade: Shade, p: Vector) -> float:
    """About how far p is from the formation, cm; negative inside."""
    nx, ny, nz = shade.field.shape
    x = (p[0] - shade.corner[0]) / shade.cell
    y = (p[1] - shade.corner[1]) / shade.cell
    z = (p[2] - shade.corner[2]) / shade.cell
    u, v = min(max(x, 0.0), nx - 1.001), min(max(y, 0.0), ny - 1.001)
    w = min(max(z, 0.0), nz - 1.001)
    i, j, k = int(u), int(v), int(w)
    outside = math.sqrt((x - u) ** 2 + (y - v) ** 2 + (z - w) ** 2) * shade.cell
    u, v, w = u - i, v - j, w - k
    f = shade.field
    low = (1.0 - v) * ((1.0 - u) * f[i, j, k] + u * f[i + 1, j, k]) + v * (
        (1.0 - u) * f[i, j + 1, k] + u * f[i + 1, j + 1, k]
    )
    high = (1.0 - v) * ((1.0 - u) * f[i, j, k + 1] + u * f[i + 1, j, k + 1]) + v * (
        (1.0 - u) * f[i, j + 1, k + 1] + u * f[i + 1, j + 1, k + 1]
    )
    return outside + (1.0 - w) * low + w * high


@kernel
def openness(shade: Shade, places: Array, normals: Array) -> Array:
    """The share (n,) of the sky's light that a formation lets through to places, 0 to 1."""
    out = np.empty(len(places))
    for i in range(len(places)):
        n = vector(normals[i])
        p = plus(vector(places[i]), times(2.0, n))
        if shade_distance(shade, p) > shade.reach:
            out[i] = 1.0
            continue
        light = 0.0
        for k in range(len(SKY)):
            sky = vector(SKY[k])
            light += min(2.0 * (0.5 + 0.5 * dot(n, sky)), 1.0) * passes(shade, p, sky, 0.5)
        out[i] = light / len(SKY)
    return out


@kernel
def passes(shade: Shade, p: Vector, way: Vector, wide: float) -> float:
    """Share of a cone of light, `wide` times as wide as long, that reaches p."""
    left, along = 1.0, 7.0
    for _ in range(7):
        gap = shade_distance(shade, plus(p, times(along, way))) + 6.0
        left = min(left, 0.2 + gap / (wide * along + 3.0))
        if left <= 0.0:
            return 0.0
        along = along * 1.2 + max(gap, 0.0) + 4.0
    return min(left, 1.0)


STEM_CM = 700.0  # depth below its top to which a pillar is sampled


class Samples(NamedTuple):
    """Places on the drawn stone."""

    place: Array  # (n, 3) cm
    normal: Array  # (n, 3) unit vectors outward, over a stretch of PROBE_CM
    open: Array  # (n,) share of the sky's light that stone lets through, 0 to 1
    stone: Ints  # (n,) the solid that each belongs to, pillars before rocks


def samples(pillars: Array, rocks: Array, per_m2: float) -> Samples:
    """About `per_m2` places for each square metre of stone, even over it, stone by stone.

    They lie within about 1 cm of the drawn surface, also on undersides and in the ground: the
    caller drops what is below the seabed or faces the wrong way. Each stone is sampled by its own
    random numbers, so that moving one leaves the others as they are.
    """
    found = numbered_formations(pillars, rocks)
    if not found:
        return Samples(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, np.int64))
    keys = stone_keys(pillars, rocks)
    strewn = [_scattered(blocks, keys[own], per_m2) for blocks, own in found]
    with ThreadPoolExecutor() as pool:  # kernels release the GIL
        blocks = (part.tobytes() for part, _ in found)
        places = (np.concatenate(parts).tobytes() for parts in strewn)
        all_of = list(pool.map(_on_stone, blocks, places))
    stones = []
    for (_, own), parts, (kept, *_) in zip(found, strewn, all_of, strict=True):
        stones.append(np.repeat(own, [len(part) for part in parts])[kept])
    stone = np.concatenate(stones)
    place, normal, light = (np.concatenate(part) for part in list(zip(*all_of, strict=True))[1:])
    order = np.argsort(stone, kind="stable")
    return Samples(place[order], normal[order], light[order], stone[order])


def _scattered(blocks: Array, keys: Ints, per_m2: float) -> list[Array]:
    """Places (n, 3) near the surface of each block of a formation."""
    out = []
    for block, key in zip(blocks, keys.tolist(), strict=True):
        rng = np.random.default_rng([key, 0x5707])
        on_block = _on_pillar if np.isinf(block[5]) else _on_rock
        out.append(on_block(block, per_m2, rng))
    return out


@lru_cache(maxsize=32)
def _on_stone(blocks: bytes, places: bytes) -> tuple[Bools, Array, Array, Array]:
    """Places (n, 3) moved onto a formation of blocks (k, 11).

    Returns a mask of those that reached it, and their place, normal and openness.

    Cached, as moving one formation leaves the others as they are.
    """
    stone = np.frombuffer(blocks).reshape(-1, 11).copy()
    strewn = np.frombuffer(places).reshape(-1, 3).copy()
    place, normal, error = on_the_surface(stone, strewn, 4)
    there = error < 2.0
    place, normal = place[there], normal[there]
    return there, place, normal, openness(shade_of(stone), place, normal)


def _on_rock(block: Array, per_m2: float, rng: np.random.Generator) -> Array:
    """Places (n, 3), even over an ellipsoid somewhat smaller than the rock."""
    half = block[3:6] - block[8] - 0.4 * block[9]
    # Points of a stretched sphere crowd where it is stretched least.
    number = per_m2 / 1e4 * 4 * np.pi * half.prod() / half.min()
    unit = rng.normal(size=(int(np.ceil(number)), 3))
    unit /= np.maximum(np.linalg.norm(unit, axis=1, keepdims=True), 1e-12)
    chosen = rng.uniform(size=len(unit)) < np.linalg.norm(unit / half, axis=1) * half.min()
    x, y, z = (unit[chosen] * half).T
    c, s = block[6:8]
    return np.asarray(block[:3] + np.stack([c * x - s * y, s * x + c * y, z], axis=1))


def _on_pillar(block: Array, per_m2: float, rng: np.random.Generator) -> Array:
    """Places (n, 3), even over the top and the upper part of a cylinder in the pillar."""
    radius = block[3] - block[8] - 0.6 * block[9]
    number = per_m2 / 1e4 * np.pi * radius * (radius + 2.0 * STEM_CM)
    turn, low = rng.uniform((0.0, -0.5 * radius), (2 * np.pi, STEM_CM), (int(number) + 1, 2)).T
    # Points above the top are put on it.
    away = np.where(low < 0.0, radius * np.sqrt(np.maximum(-2.0 * low / radius, 0.0)), radius)
    x, y, z = away * np.cos(turn), away * np.sin(turn), -np.maximum(low, 0.0)
    return np.asarray(block[:3] + np.stack([x, y, z], axis=1))
