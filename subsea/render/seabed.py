"""The seabed: the height field in square tiles, of which a view draws those that it can see."""

from itertools import pairwise
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame import Packet, Scene
from subsea.render.shaders import program, set_uniforms
from subsea.view.camera import View
from subsea.view.culling import IN_SIGHT, frustum_planes

Array = NDArray[np.floating[Any]]

TILES = 16  # per side
APRON_CM = 90.0 * np.arange(1, 17)  # the edge's height goes on outward, into the fog
FINEST_CELL_CM = 40.0  # smaller cells cost triangles that the smooth dunes do not need


class Seabed:
    """Holds the vertices and the triangles, sorted by tile."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Lay the triangles out; `scene.terrain` as SMC §6.2 has it."""
        width = scene.terrain_half_width_cm
        positions, slopes = surface(thinned(scene.terrain, width), width)
        triangles, self._first = tiles(len(positions))
        corners = positions.reshape(-1, 3)[triangles]
        self._centre, self._radius = _spheres(corners, self._first)
        self._reach = IN_SIGHT * scene.water.visibility_cm
        self._program = program(context, "seabed")
        vertices = np.concatenate([positions, slopes], axis=2).astype("f4")
        self._vertices = context.buffer(vertices.tobytes())
        self._triangles = context.buffer(triangles.astype("i4").tobytes())
        self._array = context.vertex_array(
            self._program,
            [(self._vertices, "3f4 2f4", "a_position", "a_slope")],
            self._triangles,
        )

    def draw(self, packet: Packet, view: View, uniforms: dict[str, Any]) -> int:
        """Draw the tiles in sight; the number of triangles."""
        set_uniforms(self._program, **uniforms)
        planes = frustum_planes(view)
        above = self._centre @ planes[:, :3].T + planes[:, 3] > -self._radius[:, None]
        near = np.linalg.norm(self._centre - view.eye, axis=1) - self._radius < self._reach
        total = 0
        for tile in np.flatnonzero(above.all(axis=1) & near):
            first, count = self._first[tile], self._first[tile + 1] - self._first[tile]
            self._array.render(moderngl.TRIANGLES, vertices=3 * int(count), first=3 * int(first))
            total += int(count)
        return total

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self._array, self._vertices, self._triangles, self._program):
            held.release()


def thinned(heights: Array, half_width: float) -> Array:
    """Every second height, as often as the cells are smaller than need be."""
    cells = len(heights) - 1
    while cells % 2 == 0 and 2 * half_width / cells < FINEST_CELL_CM:
        heights, cells = heights[::2, ::2], cells // 2
    return heights


def drawn_height(heights: Array, half_width: float, x: Array, y: Array) -> Array:
    """Height of the drawn triangles at places of any shape, cm; `heights` are thinned."""
    last = len(heights) - 1
    u = np.clip((x + half_width) / (2 * half_width) * last, 0, last)
    v = np.clip((y + half_width) / (2 * half_width) * last, 0, last)
    j, i = np.minimum(u.astype(int), last - 1), np.minimum(v.astype(int), last - 1)
    u, v = u - j, v - i
    east, north = heights[i, j + 1], heights[i + 1, j]
    near = heights[i, j] + u * (east - heights[i, j]) + v * (north - heights[i, j])
    corner = heights[i + 1, j + 1]
    far = corner + (1 - u) * (north - corner) + (1 - v) * (east - corner)
    return np.asarray(np.where(u + v <= 1.0, near, far))


def surface(heights: Array, half_width: float) -> tuple[Array, Array]:
    """Positions (m, m, 3) in cm and slopes (m, m, 2) along x and y, with the apron around."""
    apron = half_width + APRON_CM
    axis = np.concatenate([-apron[::-1], np.linspace(-half_width, half_width, len(heights)), apron])
    z = np.pad(heights.astype(np.float64), len(APRON_CM), mode="edge")
    x, y = np.meshgrid(axis, axis)
    slope_y, slope_x = np.gradient(z, axis, axis)
    return np.stack([x, y, z], axis=2), np.stack([slope_x, slope_y], axis=2)


def tiles(side: int) -> tuple[NDArray[np.integer[Any]], NDArray[np.integer[Any]]]:
    """Triangles (n, 3) over side² vertices, counter-clockwise from above, sorted by tile.

    Also the first triangle of each tile, with the end of the last.
    """
    i, j = np.meshgrid(range(side - 1), range(side - 1), indexing="ij")
    tile = (i * TILES // (side - 1) * TILES + j * TILES // (side - 1)).ravel()
    order = np.argsort(tile, kind="stable")
    a = (i * side + j).ravel()[order]
    triangles = np.stack([a, a + 1, a + side, a + side, a + 1, a + side + 1], axis=1)
    counts = np.bincount(tile, minlength=TILES * TILES)
    return triangles.reshape(-1, 3), np.concatenate([[0], 2 * np.cumsum(counts)])


def _spheres(corners: Array, first: NDArray[np.integer[Any]]) -> tuple[Array, Array]:
    """Centres (t, 3) and radii (t,) of the tiles' bounding spheres."""
    centres, radii = [], []
    for start, end in pairwise(first):
        points = corners[start:end].reshape(-1, 3)
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        centres.append(centre)
        radii.append(np.linalg.norm(points - centre, axis=1).max())
    return np.array(centres), np.array(radii)
