"""Marks over finished pictures: the grid and the points of line-up on the wall."""

from typing import Any

import moderngl

from subsea.base.arrays import Array
from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.shaders import program
from subsea.view.rig import Rect


class MarkRenderer(GpuOwner):
    """Draws coloured triangles over a patch, beyond its masks and its blend."""

    def __init__(self, context: Any) -> None:
        """Compile the program."""
        super().__init__()
        self._context = context
        self._program = self.own(program(context, "marks"))

    def draw(self, triangles: Array, place: Rect) -> None:
        """Draw corners (n, 5) into the framebuffer in use: x, y in shares of `place`, and RGB."""
        context = self._context
        context.viewport = place
        context.disable(context.DEPTH_TEST | context.BLEND | context.CULL_FACE)
        buffer = context.buffer(triangles.astype("f4"))
        array = context.vertex_array(self._program, [(buffer, "2f 3f", "in_at", "in_colour")])
        array.render(moderngl.TRIANGLES)
        array.release()
        buffer.release()
