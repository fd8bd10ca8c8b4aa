"""A map of the sand around formations: sun, sky and rubble."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.core.arrays import Array, Bytes
from subsea.core.kernels import kernel
from subsea.geometry.noise import fractal
from subsea.geometry.vector import Vector
from subsea.habitat.stone_shade import (
    SUN,
    Shade,
    box_of,
    openness,
    passes,
    shade_distance,
    shade_of,
)

Floor = Callable[[Array, Array], Array]  # x and y in cm -> height of the seabed in cm

TEXEL_CM, MOST_TEXELS = 8.0, 1024  # size, and most per side of the map
REACH_CM = 170.0  # distance at which formations have no effect
SUN_WIDE = 0.2  # width of the cone of sunlight, for soft shadows
RUBBLE_CM = 90.0  # decay length of rubble around a formation
UP = np.array([[0.0, 0.0, 1.0]])


class GroundMap(NamedTuple):
    """The map and its place; its edge extends outward."""

    light: Bytes  # (rows, columns, 4): sun, sky, rubble, unused; 255 is 1
    corner: Array  # (2,) cm, lowest x and y
    size: Array  # (2,) cm


def ground_map(formations: list[Array], floor: Floor, sun: Vector = SUN) -> GroundMap:
    """The map of formations, which are arrays of blocks (`habitat.formations`).

    `sun` is the direction toward the sun, below the surface.
    """
    if not formations:
        return GroundMap(np.full((1, 1, 4), (255, 255, 0, 255), np.uint8), np.zeros(2), np.ones(2))
    boxes = [np.array(box_of(blocks))[:, :2] for blocks in formations]
    low = np.min([box[0] for box in boxes], axis=0) - REACH_CM
    high = np.max([box[1] for box in boxes], axis=0) + REACH_CM
    texel = max(TEXEL_CM, float((high - low).max()) / MOST_TEXELS)
    columns, rows = np.ceil((high - low) / texel).astype(int)
    x = low[0] + texel * (np.arange(columns) + 0.5)
    y = low[1] + texel * (np.arange(rows) + 0.5)
    light = np.empty((rows, columns, 3))
    light[:] = 1.0, 1.0, 0.0

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
        return part, _light(shade_of(blocks), places, fade, sun).reshape(*across.shape, 3)

    with ThreadPoolExecutor() as pool:
        for part, found in pool.map(around, formations):
            light[part][..., :2] *= found[..., :2]
            light[part][..., 2] = np.maximum(light[part][..., 2], found[..., 2])
    out = np.full((rows, columns, 4), 255, np.uint8)
    out[..., :3] = np.round(255.0 * np.clip(light, 0.0, 1.0))
    return GroundMap(out, low, texel * np.array([columns, rows], np.float64))


def upload(context: Any, ground: GroundMap) -> Any:
    """The map as a texture."""
    rows, columns = ground.light.shape[:2]
    texture = context.texture((columns, rows), 4, np.ascontiguousarray(ground.light).tobytes())
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    texture.repeat_x = texture.repeat_y = False
    return texture


@kernel
def _light(shade: Shade, places: Array, fade: Array, sun: Vector) -> Array:
    """Sun, sky and rubble (n, 3) at points on the sand (n, 3); `fade` (n,) weighs the effect."""
    out = np.empty((len(places), 3))
    for i in range(len(places)):
        x, y, z = places[i]
        gap = shade_distance(shade, (x, y, z))
        out[i, 0], out[i, 1], out[i, 2] = 1.0, 1.0, 0.0
        if fade[i] == 0.0:
            continue
        sunny = passes(shade, (x, y, z + 1.0), sun, SUN_WIDE)
        sky = openness(shade, places[i : i + 1], UP)[0]
        out[i, 0] = 1.0 - fade[i] * (1.0 - sunny)
        out[i, 1] = 1.0 - fade[i] * (1.0 - sky)
        patch = fractal(x / 80.0, y / 80.0, 3.3, 3)
        rubble = np.exp(-max(gap - 8.0, 0.0) / RUBBLE_CM) * (0.9 + 1.1 * patch)
        out[i, 2] = fade[i] * min(max(rubble, 0.0), 1.0)
    return out
