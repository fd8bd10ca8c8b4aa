"""Rock formations as triangles: in three levels of detail, with the light that reaches them.

The surface is where `habitat.formations.drawn_distance` is 0: inside of what the fishes avoid.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.habitat.formations import (
    SUN,
    carved,
    drawn_distance,
    on_the_surface,
    openness,
    passes,
    plain_distance,
)
from subsea.kinematics.noise import fractal
from subsea.kinematics.vector import vector
from subsea.render.isosurface import surface_net
from subsea.render.standing import Shape

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]
Floor = Callable[[Array, Array], Array]  # x and y in cm -> height of the seabed in cm

LEVELS = 3
BURIED_CM = 20.0  # a shape goes on so far below the sand
CELLS = 46.0  # along the longest side of a formation, at the finest level, but ...
FINEST_CM, COARSEST_CM = 4.5, 10.0  # ... no smaller and no larger than that
NEAR_CM = 260.0  # solids so near shade one another
SUN_WIDE = 0.16  # of the cone of light that counts as the sun: how soft shadows are

# Columns of a vertex: place, normal, then how it is lit and what grows there.
COLUMNS = 13
SKY, SUNNY, HOLLOW, ABOVE, TURF, CORALLINE, SPONGE = range(6, 13)


def shapes(formations: list[Array], floor: Floor) -> list[list[Shape]]:
    """Of each formation the levels, finest first, as `Standing` takes them."""

    def levels(blocks: Array) -> list[Shape]:
        return _levels(blocks, _neighbours(blocks, formations), floor)

    # Compiled kernels and numpy leave the interpreter to others.
    with ThreadPoolExecutor() as pool:
        return list(pool.map(levels, formations))


def _levels(blocks: Array, near: Array, floor: Floor) -> list[Shape]:
    """One field, of whose samples ever fewer are taken."""
    field, corner, cell = sampled(blocks, floor)
    return [
        _shape(field[:: 2**k, :: 2**k, :: 2**k], corner, cell * 2**k, blocks, near, floor)
        for k in range(LEVELS)
    ]


def sampled(blocks: Array, floor: Floor) -> tuple[Array, Array, float]:
    """Distances from the drawn stone on a grid about it, the grid's corner and its cells, cm."""
    low, high = box_of(blocks)
    axis_x, axis_y = (np.linspace(low[k], high[k], 9) for k in (0, 1))
    ground = floor(*np.meshgrid(axis_x, axis_y)).min()
    low[2] = max(low[2], min(float(ground), high[2] - 1.0) - BURIED_CM)
    cell = float(np.clip((high - low).max() / CELLS, FINEST_CM, COARSEST_CM))
    coarse = cell * 2 ** (LEVELS - 1)
    # One cell of every level is free all round; the lowest ones are cut by the grid's end.
    corner = low - (coarse, coarse, 0.0)
    number = np.ceil((high + coarse - corner) / coarse).astype(int) * 2 ** (LEVELS - 1) + 1
    return _sample(blocks, corner, cell, *number), corner, cell


def box_of(blocks: Array) -> tuple[Array, Array]:
    """Lowest and highest corner (3,) of what is avoided; a pillar has no lower end."""
    long = np.maximum(blocks[:, 3], blocks[:, 4])
    rise = np.where(np.isinf(blocks[:, 5]), 0.0, blocks[:, 5])
    reach = np.stack([long, long, rise], axis=1)
    low = blocks[:, :3] - reach
    low[np.isinf(blocks[:, 5]), 2] = -np.inf
    return low.min(axis=0), (blocks[:, :3] + reach).max(axis=0)


def _shape(
    field: Array, corner: Array, cell: float, blocks: Array, near: Array, floor: Floor
) -> Shape:
    cells, triangles = surface_net(field)
    # Coarse levels lie on the same surface, not on chords of it; but no place leaves its cell.
    start = corner + cell * cells
    place, normal, _ = on_the_surface(blocks, start, 1 if cell < COARSEST_CM + 0.1 else 2)
    shift = place - start
    far = np.linalg.norm(shift, axis=1) / (0.6 * cell)
    place = start + shift / np.maximum(far, 1.0)[:, None]
    vertices = np.zeros((len(place), COLUMNS), np.float32)
    vertices[:, 0:3], vertices[:, 3:6] = place, normal
    vertices[:, SKY] = openness(near, place, normal)
    _dress(blocks, near, place, normal, vertices)
    vertices[:, ABOVE] = place[:, 2] - floor(place[:, 0], place[:, 1])
    shown = vertices[:, ABOVE] > -BURIED_CM
    return Shape(vertices, triangles[shown[triangles].any(axis=1)].astype(np.int32))


def _neighbours(blocks: Array, formations: list[Array]) -> Array:
    """The blocks of a formation, and those of others that may shade it."""
    low, high = box_of(blocks)
    parts = [blocks]
    for other in formations:
        if other is not blocks:
            bottom, top = box_of(other)
            gap = np.maximum(np.maximum(bottom - high, low - top)[:2], 0.0)
            if np.hypot(*gap) < NEAR_CM:
                parts.append(other)
    return np.concatenate(parts)


@njit(cache=True, error_model="numpy", nogil=True)
def _sample(blocks: Array, corner: Array, cell: float, nx: int, ny: int, nz: int) -> Array:
    """The field (nx, ny, nz); weathered only where the surface may be."""
    out = np.empty((nx, ny, nz))
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                p = (corner[0] + cell * i, corner[1] + cell * j, corner[2] + cell * k)
                distance, relief = plain_distance(blocks, p)
                if -relief - 8.0 * cell < distance < 8.0 * cell:
                    distance += relief * carved(p)
                out[i, j, k] = distance
    return out


@njit(cache=True, error_model="numpy", nogil=True)
def _dress(blocks: Array, near: Array, place: Array, normal: Array, out: Array) -> None:
    """Enter sunlight, hollows and what grows; patches run on from one stone to the next."""
    for i in range(len(place)):
        x, y, z = place[i]
        n = vector(normal[i])
        away = (x + 4.0 * n[0], y + 4.0 * n[1], z + 4.0 * n[2])
        out[i, 7] = passes(near, away, SUN, 0.16)
        # A place whose surroundings stand out is a hollow, whatever made it.
        outside = drawn_distance(blocks, (x + 14.0 * n[0], y + 14.0 * n[1], z + 14.0 * n[2]))
        out[i, 8] = min(max(1.15 - outside / 14.0, 0.0), 1.0) + 0.4 * (carved((x, y, z)) - 0.4)
        bx = x + 30.0 * fractal(x / 90.0, y / 90.0, z / 90.0, 2)
        out[i, 10] = fractal(bx / 120.0, y / 120.0 + 7.7, z / 120.0, 3)
        out[i, 11] = fractal(bx / 85.0 + 31.0, y / 85.0, z / 85.0, 3)
        out[i, 12] = fractal(bx / 46.0, y / 46.0, z / 46.0 - 13.0, 3)
