"""The normal map of a fish's scales, with the pattern of `shaders/skin.glsl`, and its tangents."""

import numpy as np

from subsea.base.arrays import Array, Bytes, Ints
from subsea.fish import sheet_layout
from subsea.fish.raster import smoothstep
from subsea.fish.species import Species
from subsea.fish.surface import along

STEP = 2  # texels of the colours to one of the map, along a side
# From `shaders/skin.glsl`: scales per body length and from ridge to ridge; how far they tilt.
SCALES, TILT, ROUND = (72.0, 32.0), 0.24, (0.34, 0.204)
FACE = 0.02, 0.12  # body lengths behind the eye where scales begin and are whole
WEB = 0.06  # body lengths of the tail fin in which they end
SEED = 5


def scale_normals(species: Species) -> Bytes | None:
    """Compute a normal map (h, w, 3) of the scales on a sheet, bottom row first.

    Red points to the tail, green to the back. Fishes without scales and rays have none.
    """
    surface, plain = species.surface, species.skin.scales
    if not plain or surface.wing:
        return None
    width, height = (size // STEP for size in sheet_layout.SIZE)
    rows = round(sheet_layout.BODY.top * height)
    first, last = sheet_layout.borders(surface)
    x = first + (last - first) * (np.arange(width) + 0.5) / width
    y = sheet_layout.half_height(surface) * (2.0 * (np.arange(rows) + 0.5) / rows - 1.0)
    back, belly = along(surface.back, x), along(surface.belly, x)
    level = (2.0 * y[:, None] - back - belly) / np.maximum(back - belly, 1e-6)
    across = np.arccos(np.clip(level, -1.0, 1.0)) / np.pi
    slope = _scale_slopes(np.broadcast_to(x, across.shape), across)
    whole = smoothstep(x, *(surface.eye.at + edge for edge in FACE))
    whole *= 1.0 - smoothstep(x, surface.tail.begin, surface.tail.begin + WEB)
    normal = np.zeros((height, width, 3))
    normal[:rows, :, :2] = plain * (whole * (np.abs(level) < 1.0))[..., None] * slope
    normal[..., 2] = 1.0
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.round(127.5 + 127.5 * normal).astype(np.uint8)


def _scale_slopes(x: Array, across: Array) -> Array:
    """Compute slopes (..., 2), to the tail and up, as `scales` of `shaders/skin.glsl`."""
    row = across * SCALES[1]
    off = row % 1.0 - 0.5
    column = x * SCALES[0] + 0.5 * (np.floor(row) % 2.0) + 2.0 * off**2
    chance = np.random.default_rng(SEED).uniform(-0.5, 0.5, (64, 128, 2))
    own = chance[np.floor(row).astype(int) % 64, np.floor(column).astype(int) % 128]
    within = np.stack([column % 1.0 - 0.5, -off], axis=-1)
    return np.asarray(TILT * own + ROUND * within)


def tangents(points: Array, normals: Array, uv: Array, triangles: Ints) -> Array:
    """Compute tangents (n, 4) at the vertices of a mesh for a map over `uv`, which goes up.

    As in MikkTSpace: the mean over the triangles of a vertex by their angles there, level with its
    normal. The fourth number is the sign of cross(normal, tangent) as the map's way up. A vertex
    between mirrored parts keeps the sign of one of them.
    """
    corner, place = points[triangles], uv[triangles]
    one, two = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    (u1, v1), (u2, v2) = (place[:, 1] - place[:, 0]).T, (place[:, 2] - place[:, 0]).T
    area = u1 * v2 - u2 * v1
    ahead = np.sign(area)[:, None] * (v2[:, None] * one - v1[:, None] * two)
    upward = np.sign(area)[:, None] * (u1[:, None] * two - u2[:, None] * one)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
    sums, ups = np.zeros((2, len(points), 3))
    for k in range(3):
        left, right = (corner[:, (k + step) % 3] - corner[:, k] for step in (1, 2))
        sine = np.linalg.norm(np.cross(left, right), axis=1)
        angle = np.arctan2(sine, (left * right).sum(axis=1))[:, None]
        np.add.at(sums, triangles[:, k], angle * ahead)
        np.add.at(ups, triangles[:, k], angle * upward)
    way = sums - normals * (sums * normals).sum(axis=1, keepdims=True)
    size = np.linalg.norm(way, axis=1, keepdims=True)
    # Where nothing is left any way level with the normal will do.
    spare = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    spare /= np.linalg.norm(spare, axis=1, keepdims=True)
    way = np.where(size > 1e-9, way / np.maximum(size, 1e-12), spare)
    sign = np.where((np.cross(normals, way) * ups).sum(axis=1) < 0.0, -1.0, 1.0)
    return np.concatenate([way, sign[:, None]], axis=1)
