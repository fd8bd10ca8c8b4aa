"""A map of the sand around formations and growths: sun, sky and rubble."""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bytes
from subsea.base.disk_cache import cache_name, remembered
from subsea.geometry.noise import fractal
from subsea.geometry.vector import Vector, vector
from subsea.habitat.stone import (
    NO_SUNS,
    SUN,
    Shade,
    box_of,
    openness,
    passes,
    shade_distance,
    shade_of,
)
from subsea.kernels import kernel

Floor = Callable[[Array, Array], Array]  # x and y in cm -> height of the seabed in cm

TEXEL_CM, MOST_TEXELS = 5.0, 1024  # size, and most per side of the map
REACH_CM = 170.0  # distance at which formations have no effect
SUN_WIDE = 0.2  # width of the cone of sunlight, for soft shadows
RUBBLE_CM = 90.0  # decay length of rubble around a formation
UP = np.array([[0.0, 0.0, 1.0]])
NO_GROWTHS = np.zeros((0, 5))
CONTACT_CM = 5.0  # least distance over which a growth darkens the sand beside it
SKY_TAKEN, SUN_TAKEN = 0.72, 0.8  # at the foot of a growth, and in its shadow


class GroundMap(NamedTuple):
    """The map and its place; its edge extends outward."""

    light: Bytes  # (rows, columns, 4): sun, sky, rubble, unused; 255 is 1
    corner: Array  # (2,) cm, lowest x and y
    size: Array  # (2,) cm
    suns: Bytes  # (rows, columns, s): shares of the sun in other directions


def ground_map(
    formations: list[Array],
    floor: Floor,
    sun: Vector = SUN,
    growths: Array = NO_GROWTHS,
    suns: Array = NO_SUNS,
) -> GroundMap:
    """The map of formations, which are arrays of blocks (`habitat.formations`).

    `sun` is the direction toward the sun, below the surface, `suns` (s, 3) are others. The map has
    room for `growths` (k, 5), whose light `with_growths` takes.
    """
    ways = np.concatenate([np.array([sun]), suns])
    if not formations and not len(growths):
        lit, all_lit = (255, 255, 0, 255), np.full((1, 1, len(suns)), 255, np.uint8)
        return GroundMap(np.full((1, 1, 4), lit, np.uint8), np.zeros(2), np.ones(2), all_lit)
    boxes = [np.array(box_of(blocks))[:, :2] for blocks in formations]
    boxes += [np.stack([growth[:2] - growth[2], growth[:2] + growth[2]]) for growth in growths]
    low = np.min([box[0] for box in boxes], axis=0) - REACH_CM
    high = np.max([box[1] for box in boxes], axis=0) + REACH_CM
    texel = max(TEXEL_CM, float((high - low).max()) / MOST_TEXELS)
    columns, rows = np.ceil((high - low) / texel).astype(int)
    x = low[0] + texel * (np.arange(columns) + 0.5)
    y = low[1] + texel * (np.arange(rows) + 0.5)
    light = np.ones((rows, columns, 2 + len(ways)))  # rubble, sky, suns
    light[..., 0] = 0.0

    def around(blocks: Array) -> tuple[tuple[slice, slice], Array]:
        """The part of the map that a formation changes, and its factors there."""
        box = np.array(box_of(blocks))[:, :2]
        first = np.clip((box[0] - REACH_CM - low) / texel, 0, None).astype(int)
        end = np.minimum(np.ceil((box[1] + REACH_CM - low) / texel).astype(int), (columns, rows))
        part = slice(first[1], end[1]), slice(first[0], end[0])
        across, down = np.meshgrid(x[part[1]], y[part[0]])
        places = np.stack([across, down, floor(across, down)], axis=-1).reshape(-1, 3)
        gap = np.maximum(np.maximum(box[0] - places[:, :2], places[:, :2] - box[1]), 0.0)
        fade = np.clip(2.0 - 2.1 * np.hypot(*gap.T) / REACH_CM, 0.0, 1.0)
        # So that an edit lights only the sand about the stones that it moves.
        name = cache_name(_light, blocks, places, fade, ways)
        found = remembered(name, lambda: _light(shade_of(blocks), places, fade, ways))
        return part, found.reshape(*across.shape, -1)

    with ThreadPoolExecutor() as pool:
        for part, found in pool.map(around, formations):
            light[part][..., 1:] *= found[..., 1:]
            light[part][..., 0] = np.maximum(light[part][..., 0], found[..., 0])
    shares = np.round(255.0 * np.clip(light, 0.0, 1.0)).astype(np.uint8)
    out = np.full((rows, columns, 4), 255, np.uint8)
    out[..., :3] = shares[..., 2::-1]
    size = texel * np.array([columns, rows], np.float64)
    return GroundMap(out, low, size, shares[..., 3:].copy())


def with_growths(
    ground: GroundMap, growths: Array, sun: Vector, suns: Array = NO_SUNS
) -> tuple[Bytes, Bytes]:
    """The light and the suns of a map less what corals and sponges take.

    `growths` (k, 5) are x, y, radius, height and the share of the radius on which they stand, cm;
    `sun` and `suns` those of the map.
    """
    light, others = ground.light.copy(), ground.suns.copy()
    if len(growths):
        texel, stand = float(ground.size[0]) / light.shape[1], growths.astype(np.float64)
        _stand(light, stand, ground.corner, texel, sun)
        for k, way in enumerate(suns):
            other = ground.light.copy()
            other[..., 0] = ground.suns[..., k]
            _stand(other, stand, ground.corner, texel, vector(way))
            others[..., k] = other[..., 0]
    return light, others


@kernel
def _stand(light: Bytes, growths: Array, corner: Array, texel: float, sun: Vector) -> None:
    """Darken sky and sun about each growth: most at its foot, the sun's on the far side."""
    rows, columns = light.shape[:2]
    for k in range(len(growths)):
        x, y, radius, tall, foot = growths[k]
        reach = radius + 0.7 * tall + CONTACT_CM
        aside_x, aside_y = -sun[0] / sun[2] * tall, -sun[1] / sun[2] * tall
        far = reach + math.sqrt(aside_x**2 + aside_y**2)
        first, last = int((x - far - corner[0]) / texel), int((x + far - corner[0]) / texel)
        low, high = int((y - far - corner[1]) / texel), int((y + far - corner[1]) / texel)
        for row in range(max(low, 0), min(high + 1, rows)):
            for column in range(max(first, 0), min(last + 1, columns)):
                dx = corner[0] + texel * (column + 0.5) - x
                dy = corner[1] + texel * (row + 0.5) - y
                away = math.sqrt(dx * dx + dy * dy)
                # The sky: half is hidden at the foot of a wall, all beneath a plate on a stem.
                gap = max(away - foot * radius, 0.0) / (0.5 * tall + CONTACT_CM)
                sky = 1.0 - SKY_TAKEN / (1.0 + gap * gap) ** 2
                # The sun: a soft spot along the shadow.
                along = dx * aside_x + dy * aside_y
                length = aside_x * aside_x + aside_y * aside_y
                at = min(max(along / length, 0.0), 1.0) if length > 0.0 else 0.0
                off = math.sqrt((dx - at * aside_x) ** 2 + (dy - at * aside_y) ** 2)
                soft = 0.25 * radius + 0.2 * tall * at + 2.0
                share = min(max((radius + soft - off) / (2.0 * soft), 0.0), 1.0)
                sunny = 1.0 - SUN_TAKEN * share * share * (3.0 - 2.0 * share)
                light[row, column, 0] = int(light[row, column, 0] * sunny + 0.5)
                light[row, column, 1] = int(light[row, column, 1] * sky + 0.5)


@kernel
def _light(shade: Shade, places: Array, fade: Array, suns: Array) -> Array:
    """Rubble, sky and `suns` (n, 2 + s) at points on the sand (n, 3).

    `fade` (n,) weighs the effect, `suns` (s, 3) are directions toward the sun.
    """
    out = np.ones((len(places), 2 + len(suns)))
    for i in range(len(places)):
        x, y, z = places[i]
        gap = shade_distance(shade, (x, y, z))
        out[i, 0] = 0.0
        if fade[i] == 0.0:
            continue
        for k in range(len(suns)):
            sunny = passes(shade, (x, y, z + 1.0), vector(suns[k]), SUN_WIDE)
            out[i, 2 + k] = 1.0 - fade[i] * (1.0 - sunny)
        sky = openness(shade, places[i : i + 1], UP)[0]
        out[i, 1] = 1.0 - fade[i] * (1.0 - sky)
        patch = fractal(x / 80.0, y / 80.0, 3.3, 3)
        rubble = np.exp(-max(gap - 8.0, 0.0) / RUBBLE_CM) * (0.9 + 1.1 * patch)
        out[i, 0] = fade[i] * min(max(rubble, 0.0), 1.0)
    return out
