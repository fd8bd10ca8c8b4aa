"""The parts of the light of a picture, for compositing: things, the veil of water, what it hides.

Water is everywhere, so no pixel of a picture shows a thing alone. Of each pixel

    picture = subject * transmittance + veil

holds in linear light. `veil` is the light that the water itself sends, `transmittance` the share of
each colour that the water before a thing lets through, and `subject` the light of things, were the
water before them not there. Shaders compiled with PASSES write these parts, blended by the same
opacities and sampled at the same places as the picture (`shaders/show.glsl`).
"""

from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.rendering.gl.context import GpuOwner
from subsea.view.rig import Rect

WIDTHS = 3, 3, 3, 1  # components of light, veil, clear and cover


class LightParts(NamedTuple):
    """Parts of the light of a picture (h, w), top row first, float32. Each is a mean over a pixel.

    `light + veil` is the picture. Means of several pictures are the parts of their mean.
    """

    light: Array  # (h, w, 3) what arrives of the light of things
    veil: Array  # (h, w, 3) what the water adds
    clear: Array  # (h, w, 3) the share that the water lets through, times `cover`
    cover: Array  # (h, w) the share of the pixel before which things stand, and not open water

    @property
    def transmittance(self) -> Array:
        """The share (h, w, 3) that the water before things lets through; 0 in open water."""
        cover = self.cover[..., None]
        return np.where(cover > 0.0, self.clear / np.maximum(cover, 1e-12), 0.0)

    def subject(self, transmittance: Array) -> Array:
        """The light (h, w, 3) of things without the water before them, times their cover.

        `transmittance` is given as it is stored, so that the product is what arrives.
        """
        return np.where(transmittance > 0.0, self.light / np.maximum(transmittance, 1e-12), 0.0)


class PartsTarget(GpuOwner):
    """The framebuffer that the parts of the light are drawn into, in single precision."""

    def __init__(self, context: Any, size: tuple[int, int], samples: int) -> None:
        """Make it `size` (width, height) pixels large; UserError if the GPU cannot hold it."""
        super().__init__()
        self.size, self.samples, self._context = size, samples, context
        try:
            flat = [self.own(context.texture(size, 4, dtype="f4")) for _ in WIDTHS]
            self._flat = self.own(context.framebuffer(flat))
            parts = flat
            if samples:
                parts = [
                    self.own(context.renderbuffer(size, 4, samples=samples, dtype="f4"))
                    for _ in WIDTHS
                ]
            depth = self.own(context.depth_renderbuffer(size, samples=samples))
            self.framebuffer = self.own(context.framebuffer(parts, depth))
        except moderngl.Error as fault:
            self.release()
            raise UserError(
                f"passes of {size[0]}x{size[1]} pixels are more than this GPU can hold; "
                "take a smaller --size"
            ) from fault

    def release(self) -> None:
        """Free every OpenGL object."""
        # moderngl binds the last framebuffer again when it makes one, which must not be freed.
        self._context.detect_framebuffer(0).use()
        super().release()

    def read(self, part: Rect) -> LightParts:
        """Read back a part of the canvas, with samples resolved."""
        if self.samples:
            self._context.copy_framebuffer(self._flat, self.framebuffer)
        width, height = part[2:]
        planes = []
        for number, components in enumerate(WIDTHS):
            data = self._flat.read(part, components=components, attachment=number, dtype="f4")
            texels = np.frombuffer(data, np.float32).reshape(height, width, components)[::-1]
            planes.append(texels)
        light, veil, clear, cover = planes
        return LightParts(light, veil, clear, cover[..., 0])
