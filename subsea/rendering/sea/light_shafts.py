"""Shafts of sunlight: a small map of directions about the sun, redrawn for every eye."""

from typing import Any

import moderngl

from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.rendering.gl.uniforms import SHAFTS_UNIT
from subsea.rendering.output.quality import Quality

SIZE = (320, 16)  # texels: angle about the sun, cosine of the angle from it


class LightShaftRenderer(GpuOwner):
    """Draws the map, which every shader that includes `optics.glsl` reads."""

    def __init__(self, context: Any, quality: Quality) -> None:
        super().__init__()
        self._context = context
        self._map = self.own(context.texture(SIZE, 1, dtype="f2"))
        self._map.repeat_y = False
        self._framebuffer = self.own(context.framebuffer([self._map]))
        self._program = self.own(program(context, "shafts"))
        self._array = self.own(context.vertex_array(self._program, []))
        self.adapt(quality)

    def adapt(self, quality: Quality) -> None:
        """Use the number of samples of this quality; 0 draws no shafts."""
        self._samples = quality.shafts
        if not self._samples:
            self._framebuffer.clear()

    def draw(self, uniforms: dict[str, Any]) -> None:
        """Draw the map for the eye of a view. Changes the framebuffer in use and the viewport."""
        if self._samples:
            self._framebuffer.use()
            self._context.viewport, self._context.scissor = (0, 0, *SIZE), None
            self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST)
            set_uniforms(self._program, **uniforms, u_samples=self._samples)
            self._array.render(vertices=3)
        self._map.use(SHAFTS_UNIT)
