"""Pillars and rocks: weathered formations that stand in the sea."""

from functools import partial
from typing import Any

import moderngl
import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel
from subsea.frame.packet import Packet, Scene
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import vector
from subsea.habitat.formations import first_of_formation, formations
from subsea.render.gl.id_buffer import PILLAR, ROCK, object_id
from subsea.render.gl.mipmaps import Texels
from subsea.render.gl.shaders import program, set_uniforms, wanted
from subsea.render.gl.static_batch import StaticBatch, StaticMesh
from subsea.render.gl.textures import in_bytes, relief, repeating
from subsea.render.reef.rock_mesh import cut, shapes
from subsea.render.sea.seabed import drawn_height
from subsea.view.culling import IN_SIGHT

RELIEF_UNIT = 4  # texture unit
RELIEF_SPAN = np.array([1.6, 32.0, 32.0, 1.0])  # of its layers, to both sides of 0
# A piece is drawn in the finest detail while its diameter covers so many pixels, and so on.
LEVELS_PX = (900.0, 230.0)


def pieces(
    terrain: Array, half_width_cm: float, pillars: Array, rocks: Array
) -> list[list[StaticMesh]]:
    """All formations of a `Scene`, shaped and cut: of each piece the levels, finest first."""
    floor = partial(drawn_height, terrain, half_width_cm)
    found = formations(pillars, rocks)
    return [piece for levels in shapes(found, floor) for piece in cut(levels)]


def solid_marks(pillars: Array, rocks: Array, places: Array) -> Array:
    """The marks (n,) of places (n, 3) on stone: solids that overlap are one, the first of them."""
    solid = first_of_formation(pillars, rocks)[_nearest(pillars, rocks, places)]
    number = solid - len(pillars)
    return np.asarray(np.where(number < 0, object_id(PILLAR, solid), object_id(ROCK, number)))


@kernel
def _nearest(pillars: Array, rocks: Array, places: Array) -> Ints:
    """Which solid, pillars before rocks, is nearest to places (n, 3)."""
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


class RockRenderer:
    """Holds the shapes of all formations."""

    def __init__(self, context: Any, scene: Scene, stone: list[list[StaticMesh]]) -> None:
        """Upload the `pieces` of a scene's formations."""
        self._context = context
        self._held: list[Any] = []
        self._standing: StaticBatch | None = None
        self._programs: dict[tuple[str, ...], Any] = {}  # made when they are first asked for
        self._scene, self._stone = scene, stone
        if not stone:
            return
        self._programs[()] = program(context, "solid")
        self._relief = repeating(context, roughness, 5)
        self._standing = StaticBatch(
            context,
            self._programs[()],
            "3f4 3f4 4f4 3f4",
            "a_position a_normal a_light a_cover",
            stone,
            IN_SIGHT * scene.water.visibility_cm,
            LEVELS_PX,
        )
        self._held = [self._standing, self._relief, self._programs[()]]

    @property
    def standing(self) -> tuple[StaticBatch, ...]:
        """What depends on earlier packets."""
        return (self._standing,) if self._standing else ()

    def choose(self, packet: Packet, detail: float = 1.0) -> None:
        """Decide once for all views of a packet what is drawn."""
        if self._standing:
            self._standing.choose(packet.views, detail)

    def draw(self, number: int, uniforms: dict[str, Any], marked: bool = False) -> int:
        """Draw what was chosen, or marks of it; the number of triangles."""
        if self._standing is None:
            return 0
        if (wants := wanted(uniforms, marked)) not in self._programs:
            self._make(wants, self._standing)
        self._relief.use(RELIEF_UNIT)
        set_uniforms(self._programs[wants], u_relief=RELIEF_UNIT)
        self._context.enable(moderngl.CULL_FACE)
        total = self._standing.draw(number, uniforms, marked)
        self._context.disable(moderngl.CULL_FACE)
        return total

    def _make(self, wants: tuple[str, ...], standing: StaticBatch) -> None:
        """Compile another program, for marks or for lamps."""
        marks = None
        if "MARKS" in wants:
            places = [shape.vertices[:, :3] for levels in self._stone for shape in levels]
            marks = solid_marks(
                self._scene.pillars, self._scene.rocks, np.concatenate(places).astype(np.float64)
            )
        made = program(self._context, "solid", **dict.fromkeys(wants, 1), OWN_MARKS=1)
        standing.draw_by(wants, made, marks)
        self._programs[wants] = made
        self._held.append(made)

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in self._held:
            held.release()
