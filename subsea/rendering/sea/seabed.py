"""The seabed: the height field in square tiles at three levels of detail, with sand textures."""

from functools import partial
from typing import Any

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.frame.packet import Packet, RenderScene
from subsea.habitat.formations import formations
from subsea.habitat.reef import KINDS, MOUND
from subsea.habitat.stone import sun_at
from subsea.rendering.gl.id_buffer import SEABED
from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.static_batch import StaticBatch, StaticMesh
from subsea.rendering.gl.textures import repeating
from subsea.rendering.output.quality import Quality
from subsea.rendering.sea import ground_map, sand
from subsea.state import Reef
from subsea.view.culling import IN_SIGHT

CELLS = 12  # of a side of a tile; coarser levels use every second and fourth
LEVELS_PX = (640.0, 210.0)  # diameters of a tile from which its levels are used
APRON_CM = 120.0  # width of cells outside the height field, which continue its edge into the fog
SKIRT_CM = 9.0  # hides gaps between tiles of different levels
ON_SAND_CM = 3.0  # height of the foot of a growth, up to which it stands on the sand
# Radius on which a growth stands, over its own.
FOOT, FEET = 0.7, {"mound": 1.0, "brain": 0.9, "table": 0.35, "fan": 0.2, "rubble": 0.6}
GROUND_UNIT, RIPPLES_UNIT, LITTER_UNIT, TRACKS_UNIT = 8, 9, 10, 11  # texture units


class SeabedRenderer(GpuOwner):
    """Draws the tiles in sight."""

    def __init__(self, context: Any, scene: RenderScene, ground: ground_map.GroundMap) -> None:
        """Cut `scene.terrain` (SMC §6.2) into tiles; `ground` is its `surroundings`."""
        super().__init__()
        programs = ProgramVariants(context, "seabed", SEABED)
        items = tiles(*surface(scene.terrain, scene.terrain_half_width_cm))
        reach_cm = IN_SIGHT * scene.water.visibility_cm
        self._batch = self.own(
            StaticBatch(programs, "3f4 2f4", "a_position a_slope", items, reach_cm, LEVELS_PX)
        )
        self._textures = {
            GROUND_UNIT: self.own(ground_map.upload(context, ground.light)),
            RIPPLES_UNIT: self.own(repeating(context, sand.rippled, 3)),
            LITTER_UNIT: self.own(repeating(context, sand.littered, 4)),
            TRACKS_UNIT: self.own(repeating(context, sand.tracked, 8)),
        }
        self._wants: tuple[str, ...] = ()
        self._ground, self._sun = ground, sun_at(scene.water.hour)[0]
        self._standing, self._own = standing(scene.reef, scene.terrain, scene.terrain_half_width_cm)
        self._shown = -1  # number of growths whose light the map takes
        self._uniforms = {
            "u_ground": GROUND_UNIT,
            "u_ripples": RIPPLES_UNIT,
            "u_litter": LITTER_UNIT,
            "u_tracks": TRACKS_UNIT,
            "u_map": (*ground.corner, *ground.size),
            "u_flow": flow_of(scene.water.current_cm_s),
        }

    @property
    def batches(self) -> tuple[StaticBatch, ...]:
        """State that depends on earlier packets."""
        return (self._batch,)

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on: sand is darker about the growths that are drawn."""
        self._wants = quality.close_up_defines
        shown = self._standing[self._own <= quality.growth]
        if len(shown) != self._shown:
            light = ground_map.with_growths(self._ground, shown, self._sun)
            self._textures[GROUND_UNIT].write(light.tobytes())
            self._shown = len(shown)

    def choose(self, packet: Packet, detail: float = 1.0) -> None:
        """Choose what the views of a packet draw."""
        self._batch.choose(packet.views, packet.time_s, detail)

    def draw(self, number: int, uniforms: dict[str, Any], as_ids: bool = False) -> int:
        """Draw the chosen tiles or their object ids; returns the number of triangles."""
        for unit, texture in self._textures.items():
            texture.use(unit)
        wants = () if as_ids else self._wants
        return int(self._batch.draw(number, uniforms | self._uniforms, as_ids, wants))


def surroundings(
    terrain: Array, half_width_cm: float, pillars: Array, rocks: Array, hour: float, reef: Reef
) -> ground_map.GroundMap:
    """The ground map of the stones of a `RenderScene` at an hour, with room for its growths."""
    floor = partial(drawn_height, terrain, half_width_cm)
    growths = standing(reef, terrain, half_width_cm)[0]
    return ground_map.ground_map(formations(pillars, rocks), floor, sun_at(hour)[0], growths)


def flow_of(current_cm_s: tuple[float, float]) -> tuple[float, float]:
    """Unit vector along a current, along x if there is none: ripples lie across it."""
    speed = float(np.hypot(*current_cm_s))
    return (current_cm_s[0] / speed, current_cm_s[1] / speed) if speed > 0.0 else (1.0, 0.0)


def standing(reef: Reef, terrain: Array, half_width_cm: float) -> tuple[Array, Array]:
    """Growths (k, 5) on the sand, as `ground_map.with_growths` reads them, and their `own`.

    Mounds have an `own` of 0, as they are always drawn.
    """
    x, y = reef.place[:, 0], reef.place[:, 1]
    gap = reef.place[:, 2] - drawn_height(terrain, half_width_cm, x, y)
    on = ~reef.on_rock & (gap < ON_SAND_CM)
    names = list(KINDS)
    tall = np.array([KINDS[name].height for name in names])[reef.kind] * reef.radius
    foot = np.array([FEET.get(name, FOOT) for name in names])[reef.kind]
    found = np.stack([x, y, reef.radius, np.maximum(tall * reef.axis[:, 2], 1.0), foot], axis=1)
    own = np.where(reef.kind == MOUND, 0.0, reef.own)
    return found[on].astype(np.float64), own[on]


def drawn_height(heights: Array, half_width: float, x: Array, y: Array) -> Array:
    """Height of the finest triangles at points x, y of any shape, cm."""
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
    """Positions (m, m, 3), cm, and slopes (m, m, 2) with an apron; m - 1 divides by CELLS."""
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
    """The levels of each tile, finest first; vertices (n, 5) are position and slope."""
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
    """Rim (r,) of a tile of cells², and triangles (m, 3) of the tile and its skirt."""
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
