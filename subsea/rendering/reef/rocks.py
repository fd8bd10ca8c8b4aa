"""Drawing pillars and rocks: weathered formations in levels of detail, with baked light.

The surface is where `habitat.formations.drawn_distance` is 0, inside of what fishes avoid.
"""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from typing import Any

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.disk_cache import cache_name, cached, remembered
from subsea.frame.packet import RenderScene
from subsea.geometry.noise import fractal
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import Vector, vector
from subsea.geometry.walls import is_wall
from subsea.habitat.formations import NEAR_CM as NEAR_BLOCKS_CM
from subsea.habitat.formations import (
    RELIEF_CM,
    blocks_near,
    carved,
    drawn_distance,
    first_of_formation,
    formations,
    on_the_surface,
    rough_distance,
)
from subsea.habitat.stone import (
    NO_SUNS,
    SUN,
    Shade,
    box_of,
    openness,
    passes,
    shade_of,
    sun_at,
    suns_of_day,
)
from subsea.kernels import kernel
from subsea.rendering.gl.id_buffer import PILLAR, ROCK, object_id
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.static_batch import LazyMesh, StaticBatch, StaticMesh, bounding_spheres
from subsea.rendering.gl.textures import Texels, in_bytes, relief, repeating
from subsea.rendering.output.quality import Quality
from subsea.rendering.reef.coral_mesh import surface_net
from subsea.rendering.reef.fine_stone import finer, halved
from subsea.rendering.sea.seabed import drawn_height, terrain_within
from subsea.state import Reef
from subsea.view.culling import IN_SIGHT

Floor = Callable[[Array, Array], Array]  # x and y in cm -> height of the seabed in cm

# Lowest and highest corner (3,) of a box, cm -> all that the height of the seabed in it depends on.
Ground = Callable[[Array, Array], object]

LEVELS = 3
BESIDE_CM = 100.0  # about a formation, more than any vertex lies outside its box
COARSE = 2 ** (LEVELS - 1)  # finest cells along a coarsest one
BURIED_CM = 20.0  # depth of meshes below the sand
CELLS = 46.0  # along the longest side of a formation, at the finest level
FINEST_CM, COARSEST_CM = 4.5, 10.0  # limits of their size
ACROSS = 4.0  # least number of cells across a formation
PIECE_CM = 220.0  # width of a piece, which has its own level
NEAR_CM = 200.0  # formations closer than this shade one another
SUN_WIDE = 0.16  # width of the cone of sunlight, for soft shadows

# Columns of a vertex: position, normal, light and cover; then shares of the suns of a moving day.
COLUMNS = 13
SKY, SUNNY, HOLLOW, ABOVE, TURF, CORALLINE, SPONGE = range(6, 13)


def shapes(
    formations: list[Array],
    floor: Floor,
    sun: Vector = SUN,
    suns: Array = NO_SUNS,
    ground: Ground | None = None,
) -> list[list[StaticMesh]]:
    """The levels of each formation, finest first.

    `sun` is the direction toward the sun. Each of `suns` (s, 3) has one more column of vertices.
    `ground` tells what the floor about a formation depends on. With it, only formations that differ
    from those of earlier calls are shaped.
    """
    ways = np.concatenate([np.array([sun]), suns])
    # Kernels and numpy release the GIL.
    with ThreadPoolExecutor() as pool:
        shade = cache(lambda k: shade_of(formations[k]))

        def levels(number: int) -> list[StaticMesh]:
            own, near = formations[number], _neighbours(formations, number)

            def make() -> list[StaticMesh]:
                return _levels(own, [shade(k) for k in near], floor, ways)

            if ground is None:
                return make()
            low, high = box_of(own)
            about = [formations[k] for k in near], ground(low - BESIDE_CM, high + BESIDE_CM)
            return remembered(cache_name(_levels, *about, ways), make)

        shaped = list(pool.map(levels, range(len(formations))))
    # A stone deep in the sand has no triangles.
    return [own for own in shaped if len(own[0].triangles)]


def cut(levels: list[StaticMesh]) -> list[list[StaticMesh]]:
    """Cut the levels of a formation into pieces, each drawn at its own level.

    Pieces extend beyond their boxes by the length of a triangle, so that neighbours at different
    levels overlap without gaps.
    """
    low = levels[0].vertices[:, :3].min(axis=0)
    number = np.ceil(np.ptp(levels[0].vertices[:, :3], axis=0) / PIECE_CM).astype(int)
    pieces: list[list[StaticMesh]] = []
    middles = [shape.vertices[:, :3][shape.triangles].mean(axis=1) for shape in levels]
    longs = [_long(shape) for shape in levels]
    for i, j, k in np.ndindex(*np.maximum(number, 1)):
        box = low + PIECE_CM * np.array([i, j, k])
        piece = []
        for shape, middle, long in zip(levels, middles, longs, strict=True):
            beyond = np.maximum(box - middle, middle - box - PIECE_CM).max(axis=1)
            if shape is levels[0] and not (beyond <= 0.0).any():
                break
            used, corners = np.unique(shape.triangles[beyond <= long], return_inverse=True)
            # Triangles about one vertex follow each other: a renderer computes it once, not thrice.
            triangles = corners.reshape(-1, 3).astype(np.int32)
            order = np.argsort(triangles.min(axis=1), kind="stable")
            piece.append(StaticMesh(shape.vertices[used], triangles[order]))
        else:
            pieces.append(piece)
    return pieces


def _long(shape: StaticMesh) -> float:
    """Mean edge length of the triangles."""
    corners = shape.vertices[:, :3][shape.triangles]
    return float(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).mean())


def _neighbours(formations: list[Array], number: int) -> list[int]:
    """Indices of formations that may shade one, itself first."""
    low, high = box_of(formations[number])
    numbers = [number]
    for k, other in enumerate(formations):
        bottom, top = box_of(other)
        gap = np.maximum(np.maximum(bottom - high, low - top)[:2], 0.0)
        if k != number and np.hypot(*gap) < NEAR_CM:
            numbers.append(k)
    return numbers


def _levels(blocks: Array, near: list[Shade], floor: Floor, suns: Array) -> list[StaticMesh]:
    """The levels of a formation from one field: every sample, every second, and so on."""
    field, corner, cell = sampled(blocks, floor)
    levels: list[StaticMesh] = []
    for k in range(LEVELS):
        part = field[:: 2**k, :: 2**k, :: 2**k]
        shape = _shape(part, corner, cell * 2**k, blocks, near, floor, suns)
        # A thin stone may fall between coarse samples.
        levels.append(levels[-1] if levels and not len(shape.triangles) else shape)
    return levels


def sampled(blocks: Array, floor: Floor) -> tuple[Array, Array, float]:
    """Distances to the drawn stone (signs if far) on a grid, its corner and its cell size, cm."""
    low, high = box_of(blocks)
    thin = (high - low).min()
    axis_x, axis_y = (np.linspace(low[k], high[k], 9) for k in (0, 1))
    ground = floor(*np.meshgrid(axis_x, axis_y)).min()
    low[2] = max(low[2], min(float(ground), high[2] - 1.0) - BURIED_CM)
    cell = float(np.clip((high - low).max() / CELLS, FINEST_CM, COARSEST_CM))
    cell = min(cell, thin / ACROSS)
    # One free cell around at every level, except at the bottom.
    coarse = cell * COARSE
    corner = low - (coarse, coarse, 0.0)
    number = np.ceil((high + coarse - corner) / coarse).astype(int)
    return _sample(blocks, corner, cell, *number), corner, cell


def _shape(
    field: Array, corner: Array, cell: float, blocks: Array, near: list[Shade], floor: Floor,
    suns: Array,
) -> StaticMesh:  # fmt: skip
    cells, triangles = surface_net(field)
    # Vertices of coarse levels move onto the surface, but stay in their cells.
    start = corner + cell * cells
    place, normal, _ = on_the_surface(blocks, start, 1 if cell <= COARSEST_CM else 2)
    shift = place - start
    far = np.linalg.norm(shift, axis=1) / (0.6 * cell)
    place = start + shift / np.maximum(far, 1.0)[:, None]
    vertices = np.zeros((len(place), COLUMNS + len(suns) - 1), np.float32)
    vertices[:, 0:3], vertices[:, 3:6] = place, normal
    _dress(blocks, place, normal, vertices)
    vertices[:, SKY : SUNNY + 1] = 1.0
    vertices[:, COLUMNS:] = 1.0
    for shade in near:
        vertices[:, SKY] *= openness(shade, place, normal)
        _sun(shade, place, normal, suns, vertices)
    vertices[:, ABOVE] = place[:, 2] - floor(place[:, 0], place[:, 1])
    shown = vertices[:, ABOVE] > -BURIED_CM
    return StaticMesh(vertices, triangles[shown[triangles].any(axis=1)].astype(np.int32))


@kernel
def _sample(blocks: Array, corner: Array, cell: float, nx: int, ny: int, nz: int) -> Array:
    """The field at the corners of (nx, ny, nz) cubes of COARSE³ cells."""
    out = np.empty((nx * COARSE + 1, ny * COARSE + 1, nz * COARSE + 1))
    out[:] = 1e3
    half = 0.5 * COARSE * cell
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                at = (2 * i + 1, 2 * j + 1, 2 * k + 1)
                middle = (
                    corner[0] + half * at[0], corner[1] + half * at[1], corner[2] + half * at[2],
                )  # fmt: skip
                few = blocks_near(blocks, middle, NEAR_BLOCKS_CM + 2.0 * half)
                if len(few) == 0:
                    continue
                rough = rough_distance(few, middle)
                deep = rough < -RELIEF_CM - 3.0 * half
                if rough > 3.0 * half + 10.0:
                    continue
                for a in range(i * COARSE, (i + 1) * COARSE + 1):
                    for b in range(j * COARSE, (j + 1) * COARSE + 1):
                        for c in range(k * COARSE, (k + 1) * COARSE + 1):
                            if deep:
                                out[a, b, c] = -1e3
                                continue
                            if out[a, b, c] != 1e3:
                                continue  # its neighbour's too
                            p = (corner[0] + cell * a, corner[1] + cell * b, corner[2] + cell * c)
                            out[a, b, c] = drawn_distance(few, p)
    return out


@kernel
def _sun(shade: Shade, place: Array, normal: Array, suns: Array, out: Array) -> None:
    """Multiply the sunlight from each of `suns` (s, 3) by what a formation lets through."""
    for i in range(len(place)):
        x, y, z = place[i]
        n = vector(normal[i])
        away = (x + 4.0 * n[0], y + 4.0 * n[1], z + 4.0 * n[2])
        for k in range(len(suns)):
            column = SUNNY if k == 0 else COLUMNS + k - 1
            out[i, column] *= passes(shade, away, vector(suns[k]), SUN_WIDE)


@kernel
def _dress(blocks: Array, place: Array, normal: Array, out: Array) -> None:
    """Write hollows and cover; patches continue from one stone to the next."""
    for i in range(len(place)):
        x, y, z = place[i]
        n = vector(normal[i])
        few = blocks_near(blocks, (x, y, z), NEAR_BLOCKS_CM)
        # Hollow: stone lies ahead along the normal.
        outside = drawn_distance(few, (x + 14.0 * n[0], y + 14.0 * n[1], z + 14.0 * n[2]))
        out[i, 8] = min(max(1.15 - outside / 14.0, 0.0), 1.0) + 0.4 * (carved((x, y, z)) - 0.4)
        bx = x + 30.0 * fractal(x / 90.0, y / 90.0, z / 90.0, 2)
        out[i, 10] = fractal(bx / 120.0, y / 120.0 + 7.7, z / 120.0, 3)
        out[i, 11] = fractal(bx / 85.0 + 31.0, y / 85.0, z / 85.0, 3)
        out[i, 12] = fractal(bx / 46.0, y / 46.0, z / 46.0 - 13.0, 3)


RELIEF_SPAN = np.array([1.6, 32.0, 32.0, 1.0])  # largest magnitude of its layers
CAST_LEVEL = 2  # of shadows on the map of the sun
SKY_TAKEN, SUN_TAKEN = 0.6, 0.45  # at the foot of a growth
# Diameters of a piece from which its levels are used; the first is `fine_stone`.
LEVELS_PX = (3200.0, 900.0, 230.0)


def pieces(
    terrain: Array,
    half_width_cm: float,
    pillars: Array,
    rocks: Array,
    hour: float,
    moving: bool = False,
) -> list[list[StaticMesh]]:
    """The formations of a `RenderScene` in pieces: the levels of each piece, finest first.

    `hour` tells where the sun is; with `moving` they have the shade of all suns of a day, too.
    """
    floor = partial(drawn_height, terrain, half_width_cm)
    blocks, sun = formations(pillars, rocks), sun_at(hour)[0]
    ground = partial(terrain_within, terrain, half_width_cm)
    shaped = shapes(blocks, floor, sun, suns_of_day(moving), ground)
    return [piece for levels in shaped for piece in cut(levels)]


def overgrown(
    terrain: Array,
    half_width_cm: float,
    pillars: Array,
    rocks: Array,
    hour: float,
    reef: Reef,
    moving: bool = False,
) -> list[list[StaticMesh]]:
    """As `pieces`, darker where `reef` grows on the stone."""
    shaped = pieces(terrain, half_width_cm, pillars, rocks, hour, moving)
    on = reef.on_rock
    growths = np.column_stack([reef.place[on], reef.radius[on], reef.axis[on]]).astype(np.float64)
    for mesh in {id(mesh): mesh for levels in shaped for mesh in levels}.values():
        _darken(mesh.vertices, growths)
    return shaped


@kernel
def _darken(vertices: Array, growths: Array) -> None:
    """Take light of sky and sun from vertices of stone about the feet of growths (k, 7)."""
    for k in range(len(growths)):
        x, y, z, radius, ax, ay, az = growths[k]
        reach = 1.6 * radius
        for i in range(len(vertices)):
            dx, dy, dz = vertices[i, 0] - x, vertices[i, 1] - y, vertices[i, 2] - z
            if abs(dx) > reach or abs(dy) > reach or abs(dz) > reach:
                continue
            up = dx * ax + dy * ay + dz * az
            flat = math.sqrt(max(dx * dx + dy * dy + dz * dz - up * up, 0.0))
            away = flat / radius + abs(up) / radius
            share = min(max((1.6 - away) / 1.3, 0.0), 1.0)
            share = share * share * (3.0 - 2.0 * share)
            vertices[i, SKY] *= 1.0 - SKY_TAKEN * share
            vertices[i, SUNNY] *= 1.0 - SUN_TAKEN * share
            for column in range(COLUMNS, vertices.shape[1]):
                vertices[i, column] *= 1.0 - SUN_TAKEN * share


def object_ids(pillars: Array, rocks: Array, places: Array) -> Array:
    """Object ids (n,) of points (n, 3) on stone; overlapping solids have that of the first."""
    # Walls are not drawn: set far away, they are the nearest of no point.
    far_walls = np.where(is_wall(pillars)[:, None], pillars * (9.0, 9.0, 1.0, 1.0), pillars)
    solid = first_of_formation(pillars, rocks)[_nearest(far_walls, rocks, places)]
    number = solid - len(pillars)
    return np.asarray(np.where(number < 0, object_id(PILLAR, solid), object_id(ROCK, number)))


@kernel
def _nearest(pillars: Array, rocks: Array, places: Array) -> Ints:
    """Index of the solid, pillars before rocks, that is nearest to each point (n, 3)."""
    out = np.zeros(len(places), np.int64)
    for i in range(len(places)):
        p, least = vector(places[i]), np.inf
        for k in range(len(pillars) + len(rocks)):
            rock = k - len(pillars)
            gap = from_pillar(pillars[k], p)[1] if rock < 0 else from_rock(rocks[rock], p)[1]
            if gap < least:
                least, out[i] = gap, k
    return out


def roughness(seed: int) -> Texels:
    """The relief of stone as a texture."""
    return in_bytes(relief(seed), -RELIEF_SPAN, RELIEF_SPAN)


class RockRenderer(StaticBatch):
    """Draws the pieces of formations in sight."""

    def __init__(
        self, context: Any, scene: RenderScene, stone: list[list[StaticMesh]], quality: Quality
    ) -> None:
        """`stone` are the `pieces` of the scene."""
        fine = [halved(levels[0]) for levels in stone]

        def ids() -> Array:
            shapes = [
                mesh for own, levels in zip(fine, stone, strict=True)
                for mesh in (own.rough, *(level.vertices for level in levels))
            ]  # fmt: skip
            places = np.concatenate([shape[:, :3] for shape in shapes])
            return cached(object_ids, scene.pillars, scene.rocks, places.astype(np.float64))

        layout = "3f4 3f4 4f4 3f4", "a_position a_normal a_light a_cover"
        moving = {"MOVING_SUN": 1} if scene.water.day_minutes else {}
        if moving:
            layout = f"{layout[0]} 4f4 4f4", f"{layout[1]} a_early a_late"
        programs = ProgramVariants(context, "solid", ids, quality.defines, **moving)
        reach_cm = IN_SIGHT * scene.water.visibility_cm
        blocks = formations(scene.pillars, scene.rocks)
        items: list[list[StaticMesh | LazyMesh]] = [
            [finer(own, blocks), *levels] for own, levels in zip(fine, stone, strict=True)
        ]
        balls = bounding_spheres(stone)
        super().__init__(programs, *layout, items, reach_cm, LEVELS_PX, balls)
        if stone:
            # Neighbours overlap, more at coarse levels.
            places = [np.concatenate([one.vertices[:, :3] for one in own]) for own in stone]
            self._low = np.stack([own.min(axis=0) for own in places]).astype(np.float64)
            self._high = np.stack([own.max(axis=0) for own in places]).astype(np.float64)
            self.textures["u_relief"] = self.own(repeating(context, roughness, 5))
