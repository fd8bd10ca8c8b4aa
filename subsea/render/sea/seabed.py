"""The seabed: the height field in square tiles, in three levels of detail, and what lies on it."""

from functools import partial
from typing import Any

import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.frame.packet import Packet, Scene
from subsea.habitat.formations import formations
from subsea.render.gl.id_buffer import SEABED, object_id
from subsea.render.gl.shaders import program, set_uniforms, wanted
from subsea.render.gl.static_batch import StaticBatch, StaticMesh
from subsea.render.gl.textures import repeating
from subsea.render.sea import ground_map, sand
from subsea.view.culling import IN_SIGHT

CELLS = 12  # of a tile, along each side; every second and every fourth on coarser levels
LEVELS_PX = (640.0, 210.0)  # a level is used while its tile's diameter covers so many pixels
APRON_CM = 120.0  # the edge's height goes on outward in cells so wide, into the fog
SKIRT_CM = 9.0  # hangs from a tile's rim, where it meets one of another level
GROUND_UNIT, RIPPLES_UNIT, LITTER_UNIT = 8, 9, 10  # texture units


class SeabedRenderer:
    """Holds the tiles and the textures of the sand."""

    def __init__(self, context: Any, scene: Scene, about: ground_map.GroundMap) -> None:
        """Lay the tiles; `scene.terrain` as SMC §6.2 has it, `about` are its `surroundings`."""
        width = scene.terrain_half_width_cm
        self._context = context
        # Others are made when they are first asked for.
        self._programs: dict[tuple[str, ...], Any] = {(): program(context, "seabed")}
        self._standing = StaticBatch(
            context,
            self._programs[()],
            "3f4 2f4",
            "a_position a_slope",
            tiles(*surface(scene.terrain, width)),
            IN_SIGHT * scene.water.visibility_cm,
            LEVELS_PX,
        )
        self._map = (*about.corner, *about.size)
        self._textures = [
            ground_map.upload(context, about),
            repeating(context, sand.rippled, 3),
            repeating(context, sand.littered, 4),
        ]

    @property
    def standing(self) -> tuple[StaticBatch, ...]:
        """What depends on earlier packets."""
        return (self._standing,)

    def choose(self, packet: Packet, detail: float = 1.0) -> None:
        """Decide once for all views of a packet what is drawn."""
        self._standing.choose(packet.views, detail)

    def draw(self, number: int, uniforms: dict[str, Any], marked: bool = False) -> int:
        """Draw the tiles that were chosen, or their marks; the number of triangles."""
        if (wants := wanted(uniforms, marked)) not in self._programs:
            made = program(self._context, "seabed", **dict.fromkeys(wants, 1))
            self._standing.draw_by(wants, made)
            self._programs[wants] = made
        units = (GROUND_UNIT, RIPPLES_UNIT, LITTER_UNIT)
        for texture, unit in zip(self._textures, units, strict=True):
            texture.use(unit)
        set_uniforms(
            self._programs[wants],
            u_ground=GROUND_UNIT, u_ripples=RIPPLES_UNIT, u_litter=LITTER_UNIT, u_map=self._map,
        )  # fmt: skip
        return self._standing.draw(number, uniforms | {"u_mark": object_id(SEABED)}, marked)

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self._standing, *self._textures, *self._programs.values()):
            held.release()


def surroundings(
    terrain: Array, half_width_cm: float, pillars: Array, rocks: Array
) -> ground_map.GroundMap:
    """What the stone of a `Scene` does to the sand about it."""
    floor = partial(drawn_height, terrain, half_width_cm)
    return ground_map.ground_map(formations(pillars, rocks), floor)


def drawn_height(heights: Array, half_width: float, x: Array, y: Array) -> Array:
    """Height of the drawn triangles at places of any shape, cm, at the finest level."""
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
    """Positions (m, m, 3) in cm and slopes (m, m, 2) along x and y, with the apron around.

    The apron makes the number of cells on a side a multiple of CELLS.
    """
    before = CELLS
    after = CELLS + (1 - len(heights)) % CELLS
    axis = np.concatenate(
        [
            -half_width - APRON_CM * np.arange(before, 0, -1),
            np.linspace(-half_width, half_width, len(heights)),
            half_width + APRON_CM * np.arange(1, after + 1),
        ]
    )
    z = np.pad(heights.astype(np.float64), (before, after), mode="edge")
    x, y = np.meshgrid(axis, axis)
    slope_y, slope_x = np.gradient(z, axis, axis)
    return np.stack([x, y, z], axis=2), np.stack([slope_x, slope_y], axis=2)


def tiles(positions: Array, slopes: Array) -> list[list[StaticMesh]]:
    """Of each tile the levels, finest first, as `StaticBatch` takes them: vertices (n, 5)."""
    vertices = np.concatenate([positions, slopes], axis=2).astype(np.float32)
    meshes = [_mesh(CELLS // step) for step in (1, 2, 4)]
    found = []
    for i in range(0, len(vertices) - 1, CELLS):
        for j in range(0, len(vertices) - 1, CELLS):
            tile = vertices[i : i + CELLS + 1, j : j + CELLS + 1]
            levels = []
            for step, (rim, triangles) in zip((1, 2, 4), meshes, strict=True):
                top = tile[::step, ::step].reshape(-1, 5)
                skirt = top[rim]
                skirt[:, 2] -= SKIRT_CM
                levels.append(StaticMesh(np.concatenate([top, skirt]), triangles))
            found.append(levels)
    return found


def _mesh(cells: int) -> tuple[Ints, Ints]:
    """The rim (r,) of a tile of cells², and triangles (m, 3) of the tile and of its skirt."""
    side = cells + 1
    i, j = (k.ravel() for k in np.meshgrid(range(cells), range(cells), indexing="ij"))
    a = i * side + j
    inner = np.stack([a, a + 1, a + side, a + side, a + 1, a + side + 1], axis=1).reshape(-1, 3)
    grid = np.arange(side * side).reshape(side, side)
    rim = np.concatenate([grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]])
    below = side * side + np.arange(len(rim))
    there, deep = np.roll(rim, -1), np.roll(below, -1)
    skirt = np.stack([rim, below, there, there, below, deep], axis=1).reshape(-1, 3)
    return rim, np.concatenate([inner, skirt]).astype(np.int32)
