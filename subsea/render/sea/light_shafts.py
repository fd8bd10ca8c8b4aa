"""Shafts of light: a small map of all directions about the sun, made anew for every eye."""

from typing import Any

import moderngl

from subsea.render.gl.shaders import program, set_uniforms
from subsea.render.output.quality import Quality
from subsea.render.output.uniforms import SHAFTS_UNIT

SIZE = (320, 16)  # turns about the sun, cosines of the angle from it


class LightShaftRenderer:
    """Holds the map; whoever includes `optics.glsl` reads it."""

    def __init__(self, context: Any, quality: Quality) -> None:
        """An empty map: no shafts until the first `cast`."""
        self._context = context
        self._map = context.texture(SIZE, 1, dtype="f2")
        self._map.repeat_y = False
        self._picture = context.framebuffer([self._map])
        self._program = program(context, "shafts")
        self._array = context.vertex_array(self._program, [])
        self.adapt(quality)

    def adapt(self, quality: Quality) -> None:
        """Add up so many places of entry from now on; 0 leaves the water without shafts."""
        self._samples = quality.shafts
        if not self._samples:
            self._picture.clear()

    def cast(self, uniforms: dict[str, Any]) -> None:
        """Fill the map for the eye of a view. Changes the framebuffer in use and the viewport."""
        if self._samples:
            self._picture.use()
            self._context.viewport, self._context.scissor = (0, 0, *SIZE), None
            self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST)
            set_uniforms(self._program, **uniforms, u_samples=self._samples)
            self._array.render(vertices=3)
        self._map.use(SHAFTS_UNIT)

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self._array, self._program, self._picture, self._map):
            held.release()
