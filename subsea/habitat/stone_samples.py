"""Sites for corals, distributed evenly over the drawn stone."""

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.habitat.formations import numbered_formations, on_the_surface, stone_keys
from subsea.habitat.stone_shade import openness, shade_of

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
