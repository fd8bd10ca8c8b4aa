"""Pillars and rocks: weathered formations that stand in the sea."""

from functools import partial
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame import Packet, Scene
from subsea.habitat.formations import formations
from subsea.render.seabed import drawn_height
from subsea.render.shaders import program, set_uniforms
from subsea.render.standing import Shape, Standing
from subsea.render.stone import cut, shapes
from subsea.render.textures import relief, upload_bytes
from subsea.view.culling import IN_SIGHT

Array = NDArray[np.floating[Any]]

RELIEF_UNIT = 4  # texture unit
RELIEF_SPAN = np.array([1.6, 32.0, 32.0, 1.0])  # of its layers, to both sides of 0
# A piece is drawn in the finest detail while its diameter covers so many pixels, and so on.
LEVELS_PX = (900.0, 230.0)


def pieces(scene: Scene) -> list[list[Shape]]:
    """All formations of a scene, shaped and cut: of each piece the levels, finest first."""
    floor = partial(drawn_height, scene.terrain, scene.terrain_half_width_cm)
    found = formations(scene.pillars, scene.rocks)
    return [piece for levels in shapes(found, floor) for piece in cut(levels)]


class Solids:
    """Holds the shapes of all formations."""

    def __init__(self, context: Any, scene: Scene, stone: list[list[Shape]]) -> None:
        """Upload the `pieces` of a scene's formations."""
        self._context = context
        self._held: list[Any] = []
        self._standing: Standing | None = None
        if not stone:
            return
        self._program = program(context, "solid")
        self._relief = upload_bytes(context, relief(5), -RELIEF_SPAN, RELIEF_SPAN)
        self._standing = Standing(
            context,
            self._program,
            "3f4 3f4 4f4 3f4",
            "a_position a_normal a_light a_cover",
            stone,
            IN_SIGHT * scene.water.visibility_cm,
            LEVELS_PX,
        )
        self._held = [self._standing, self._relief, self._program]

    def choose(self, packet: Packet, detail: float = 1.0) -> None:
        """Decide once for all views of a packet what is drawn."""
        if self._standing:
            self._standing.choose(packet.views, detail)

    def draw(self, uniforms: dict[str, Any]) -> int:
        """Draw what was chosen; the number of triangles."""
        if self._standing is None:
            return 0
        self._relief.use(RELIEF_UNIT)
        set_uniforms(self._program, u_relief=RELIEF_UNIT)
        self._context.enable(moderngl.CULL_FACE)
        total = self._standing.draw(uniforms)
        self._context.disable(moderngl.CULL_FACE)
        return total

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in self._held:
            held.release()
