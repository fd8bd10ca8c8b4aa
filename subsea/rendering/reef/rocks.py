"""Drawing pillars and rocks: weathered formations of stone."""

import math
from functools import partial
from typing import Any

import moderngl
import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.frame.packet import Packet, RenderScene
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import vector
from subsea.habitat.formations import first_of_formation, formations
from subsea.habitat.stone_shade import sun_at
from subsea.kernels import kernel
from subsea.rendering.gl.id_buffer import PILLAR, ROCK, object_id
from subsea.rendering.gl.mipmaps import Texels
from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.static_batch import StaticBatch, StaticMesh
from subsea.rendering.gl.textures import in_bytes, relief, repeating
from subsea.rendering.output.quality import Quality
from subsea.rendering.reef.rock_mesh import SKY, SUNNY, cut, shapes
from subsea.rendering.sea.seabed import drawn_height
from subsea.state import Reef
from subsea.view.culling import IN_SIGHT

RELIEF_UNIT = 4  # texture unit
RELIEF_SPAN = np.array([1.6, 32.0, 32.0, 1.0])  # largest magnitude of its layers
CAST_LEVEL = 1  # of shadows
SKY_TAKEN, SUN_TAKEN = 0.6, 0.45  # at the foot of a growth
LEVELS_PX = (900.0, 230.0)  # diameters of a piece from which its levels are used


def pieces(
    terrain: Array, half_width_cm: float, pillars: Array, rocks: Array, hour: float
) -> list[list[StaticMesh]]:
    """The formations of a `RenderScene` in pieces: the levels of each piece, finest first.

    `hour` tells where the sun is.
    """
    floor = partial(drawn_height, terrain, half_width_cm)
    found = formations(pillars, rocks)
    return [piece for levels in shapes(found, floor, sun_at(hour)[0]) for piece in cut(levels)]


def overgrown(
    terrain: Array, half_width_cm: float, pillars: Array, rocks: Array, hour: float, reef: Reef
) -> list[list[StaticMesh]]:
    """As `pieces`, darker where `reef` grows on the stone."""
    found = pieces(terrain, half_width_cm, pillars, rocks, hour)
    on = reef.on_rock
    growths = np.column_stack([reef.place[on], reef.radius[on], reef.axis[on]]).astype(np.float64)
    for mesh in {id(mesh): mesh for levels in found for mesh in levels}.values():
        _darken(mesh.vertices, growths)
    return found


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


def object_ids(pillars: Array, rocks: Array, places: Array) -> Array:
    """Object ids (n,) of points (n, 3) on stone; overlapping solids have that of the first."""
    solid = first_of_formation(pillars, rocks)[_nearest(pillars, rocks, places)]
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


class RockRenderer(GpuOwner):
    """Draws the pieces of formations in sight."""

    def __init__(
        self, context: Any, scene: RenderScene, stone: list[list[StaticMesh]], quality: Quality
    ) -> None:
        """`stone` are the `pieces` of the scene."""
        super().__init__()
        self._context = context
        self.adapt(quality)
        self._batch: StaticBatch | None = None
        if not stone:
            return

        def ids() -> Array:
            places = [mesh.vertices[:, :3] for levels in stone for mesh in levels]
            return object_ids(scene.pillars, scene.rocks, np.concatenate(places).astype(np.float64))

        self._relief = self.own(repeating(context, roughness, 5))
        layout = "3f4 3f4 4f4 3f4", "a_position a_normal a_light a_cover"
        programs = ProgramVariants(context, "solid", ids, self._wants)
        reach_cm = IN_SIGHT * scene.water.visibility_cm
        self._batch = self.own(StaticBatch(programs, *layout, stone, reach_cm, LEVELS_PX))

    @property
    def batches(self) -> tuple[StaticBatch, ...]:
        """State that depends on earlier packets."""
        return (self._batch,) if self._batch else ()

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on."""
        self._wants = quality.close_up_defines

    def choose(self, packet: Packet, detail: float = 1.0) -> None:
        """Choose what the views of a packet draw."""
        if self._batch:
            self._batch.choose(packet.views, packet.time_s, detail)

    def cast(self, compiled: Any) -> None:
        """Draw all pieces with a program that reads positions alone."""
        if self._batch:
            self._batch.cast(compiled, CAST_LEVEL)

    def draw(self, number: int, uniforms: dict[str, Any], as_ids: bool = False) -> int:
        """Draw the chosen pieces or their object ids; returns the number of triangles."""
        if self._batch is None:
            return 0
        self._relief.use(RELIEF_UNIT)
        self._context.enable(moderngl.CULL_FACE)
        wants = () if as_ids else self._wants
        total = self._batch.draw(number, uniforms | {"u_relief": RELIEF_UNIT}, as_ids, wants)
        self._context.disable(moderngl.CULL_FACE)
        return total
