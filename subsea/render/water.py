"""The open water behind everything, and its surface seen from below."""

from typing import Any

import moderngl

from subsea.frame import Packet, Scene
from subsea.render.shaders import program, set_uniforms
from subsea.view.camera import View


class Water:
    """Holds the program of the background: one triangle over the whole view."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Compile the shaders."""
        self._program = program(context, "water")
        self._triangle = context.vertex_array(self._program, [])

    def draw(self, packet: Packet, view: View, uniforms: dict[str, Any]) -> int:
        """Fill what nothing covers; the number of triangles."""
        set_uniforms(self._program, **uniforms)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        return 1

    def release(self) -> None:
        """Free every OpenGL object."""
        self._triangle.release()
        self._program.release()
