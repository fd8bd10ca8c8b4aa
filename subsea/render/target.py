"""The picture in linear light, and its way to the screen."""

import math
from collections.abc import Sequence
from itertools import chain
from typing import Any

import moderngl

from subsea.render.quality import Quality
from subsea.render.shaders import program, set_uniforms
from subsea.view.stereo import Weave
from subsea.view.surround import ALL_ROUND, ROWS, Surround, half_tangent

LINEAR = moderngl.LINEAR, moderngl.LINEAR
NEAREST = moderngl.NEAREST, moderngl.NEAREST  # quicker, where each pixel has its own


class Target:
    """A half-float picture with depth, smoothed by multisampling if asked for."""

    def __init__(self, context: Any, size: tuple[int, int], samples: int) -> None:
        """Whatever of it cannot be made, nothing of it is left behind."""
        self.size = size
        self._context = context
        self._samples = samples
        self._held: list[Any] = []
        try:
            self._picture = self._keep(context.texture(size, 4, dtype="f2"))
            self._picture.repeat_x = self._picture.repeat_y = False  # its neighbours at the edge
            self._flat = self._keep(context.framebuffer([self._picture]))
            colour = self._picture
            if samples:
                colour = self._keep(context.renderbuffer(size, 4, samples=samples, dtype="f2"))
            depth = self._keep(context.depth_renderbuffer(size, samples=samples))
            self.framebuffer = self._keep(context.framebuffer([colour], depth))
        except moderngl.Error:
            self.release()
            raise

    def _keep(self, made: Any) -> Any:
        self._held.insert(0, made)
        return made

    def picture(self) -> Any:
        """The finished picture as a texture."""
        if self._samples:
            self._context.copy_framebuffer(self._flat, self.framebuffer)
        return self._picture

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in self._held:
            held.release()


class Resolve:
    """Tone mapping and sRGB, and both eyes woven together: from a linear canvas to eight bits."""

    def __init__(self, context: Any, weaves: Sequence[Weave], smooth: bool = False) -> None:
        """For a display that takes its picture, or pictures, from the canvas in these ways.

        With `smooth` edges are smoothed where a picture is taken as it is.
        """
        self._context = context
        self._made: dict[tuple[Weave, bool], tuple[Any, Any]] = {}
        self._smooth = smooth
        for weave in weaves:
            self._program(weave)

    def adapt(self, quality: Quality) -> None:
        """Smooth edges, or not, from now on."""
        self._smooth = quality.smooth

    def _program(self, weave: Weave) -> tuple[Any, Any]:
        """The program of a weave, and an array without vertices: compiled once."""
        key = weave, self._smooth and weave == Weave.PLAIN
        if key not in self._made:
            compiled = program(self._context, "resolve", WEAVE=weave, SMOOTH=int(key[1]))
            self._made[key] = compiled, self._context.vertex_array(compiled, [])
        return self._made[key]

    def draw(
        self,
        picture: Any,
        into: Any,
        size: tuple[int, int],
        weave: Weave,
        surround: Surround = ALL_ROUND,
    ) -> None:
        """Fill the framebuffer `into`, of `size` pixels, from the canvas `picture`."""
        into.use()
        self._context.viewport = (0, 0, *size)
        wide = math.radians(surround.angle_deg), math.radians(surround.tilt_deg)
        margin = half_tangent(picture.height // ROWS) if weave >= Weave.EQUIRECTANGULAR else 1.0
        compiled, array = self._program(weave)
        set_uniforms(compiled, u_size=size, u_wide=wide, u_margin=margin)
        self._context.disable(self._context.DEPTH_TEST | self._context.BLEND)
        exact = weave == Weave.PLAIN and picture.size == size and not self._smooth
        picture.filter = NEAREST if exact else LINEAR
        picture.use(0)
        array.render(vertices=3)

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in chain.from_iterable(self._made.values()):
            held.release()
