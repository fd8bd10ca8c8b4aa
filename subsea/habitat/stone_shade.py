"""Share of the sky's light that a rock formation lets through, on a grid of distances."""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.vector import Vector, dot, plus, times, vector
from subsea.habitat.formations import rough_distance
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


def sun_at(hour: float) -> tuple[Vector, float]:
    """Direction toward the sun below the surface, and the sine of its height above it.

    In the air the sun moves on a great circle, from the horizon at 6 through noon to that at 18.
    """
    flat = math.hypot(SUN[0], SUN[1])
    aside = WATER_INDEX * flat  # Snell's law
    high = math.sqrt(1.0 - aside**2)
    turn = math.pi * (hour - 6.0) / 12.0
    along, across = math.sin(turn) * aside, math.cos(turn)
    ax, ay = SUN[0] / flat, SUN[1] / flat
    x = (along * ax + across * ay) / WATER_INDEX
    y = (along * ay - across * ax) / WATER_INDEX
    return (x, y, math.sqrt(1.0 - x * x - y * y)), math.sin(turn) * high


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
