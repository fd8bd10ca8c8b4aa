"""The mean light of several pictures, before it is developed: what a film in a camera gathers.

The mean of developed pictures would be darker: a glint would be cut off at white in each of them.
"""

from typing import Any

from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.shaders import set_uniforms, source


class ExposureSum(GpuOwner):
    """The sum of canvases of one size, in single precision."""

    def __init__(self, context: Any, size: tuple[int, int]) -> None:
        """Begin without a picture."""
        super().__init__()
        self.size, self.pictures, self._context = size, 0, context
        self._sum = self.own(context.texture(size, 4, dtype="f4"))
        self._target = self.own(context.framebuffer([self._sum]))
        self._program = self.own(
            context.program(
                vertex_shader=source("present.vert"), fragment_shader=source("mean.frag")
            )
        )
        self._triangle = self.own(context.vertex_array(self._program, []))

    def add(self, canvas: Any, first: bool) -> None:
        """Add a picture, a texture of this size; the `first` begins a sum."""
        context = self._context
        self._target.use()
        if first or not self.pictures:
            self._target.clear()
            self.pictures = 0
        context.enable(context.BLEND)
        context.blend_func = context.ONE, context.ONE
        self._draw(canvas, 1.0)
        self.pictures += 1

    def write(self, into: Any) -> None:
        """Write the mean of the pictures into a framebuffer."""
        into.use()
        self._context.disable(self._context.BLEND)
        self._draw(self._sum, 1.0 / self.pictures)

    def _draw(self, picture: Any, share: float) -> None:
        context = self._context
        context.disable(context.DEPTH_TEST | context.CULL_FACE)
        context.viewport = (0, 0, *self.size)
        set_uniforms(self._program, u_share=share)
        picture.use(0)
        self._triangle.render(vertices=3)
