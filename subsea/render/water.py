"""The open water behind everything, and its surface seen from below."""

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame import Packet, Scene
from subsea.render.shaders import program, set_uniforms
from subsea.view.camera import View

BACKGROUND_VERTICES = 6 * 64 * 36  # as `water.vert` counts its cells
RINGS, SECTORS = 12, 40  # of the disc that is the surface


class Water:
    """Holds the grid of the background and the disc of the surface."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Compile the shaders; `scene` has nothing that they need now."""
        self._context = context
        self._background = program(context, "water")
        self._grid = context.vertex_array(self._background, [])
        self._surface = program(context, "surface")
        places = disc(RINGS, SECTORS)
        self._places = context.buffer(places.tobytes())
        self._disc = context.vertex_array(self._surface, [(self._places, "2f4", "a_place")])

    def draw(self, packet: Packet, view: View, uniforms: dict[str, Any]) -> int:
        """Fill what nothing covers; the number of triangles."""
        set_uniforms(self._background, **uniforms)
        self._grid.render(moderngl.TRIANGLES, vertices=BACKGROUND_VERTICES)
        self._context.enable(moderngl.BLEND)
        set_uniforms(self._surface, **uniforms)
        self._disc.render(moderngl.TRIANGLES)
        return (BACKGROUND_VERTICES + self._disc.vertices) // 3

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self._grid, self._background, self._disc, self._places, self._surface):
            held.release()


def disc(rings: int, sectors: int) -> NDArray[np.float32]:
    """Triangles (n, 3, 2) of the unit disc; its rings crowd toward the middle."""
    radius = np.linspace(0.0, 1.0, rings + 1) ** 2
    angle = np.linspace(0.0, 2 * np.pi, sectors + 1)
    places = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    a, b, c, d = places[:-1, :-1], places[:-1, 1:], places[1:, :-1], places[1:, 1:]
    return np.stack([a, c, b, b, c, d], axis=2).reshape(-1, 3, 2).astype(np.float32)
