"""Draw a fisheye picture over a rig's finished views, before tone mapping, warps and blends."""

from typing import Any

import numpy as np

from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.rendering.gl.textures import upload
from subsea.rendering.output.vessel import clip_matrix
from subsea.view.fisheye import Fisheye, fisheye_mesh
from subsea.view.rig import CameraRig


class OverlayRenderer(GpuOwner):
    """Draws it at rest on the observer, so that it stays on a screen while the sea moves."""

    def __init__(self, context: Any) -> None:
        """Make nothing yet: few dives have an overlay."""
        super().__init__()
        self.shown: Fisheye | None = None
        self.opacity = 1.0
        self._context = context
        self._held = self.own(GpuOwner())  # the picture and its mesh
        self._made: Fisheye | None = None
        self._program: Any = None

    def draw(self, rig: CameraRig, number: int, unit: float = 1.0) -> None:
        """Draw it in the view `number` of a rig, into the framebuffer and viewport in use.

        `unit` is that of the canvas. Views beyond the rig's, such as retina pictures, have none.
        """
        if self.shown is not self._made:
            self._make()
        if self._made is None or self.opacity <= 0.0 or number >= len(rig.eyes):
            return
        context = self._context
        clip = np.ascontiguousarray(clip_matrix(rig.eyes[number]).T, "f4").tobytes()
        context.disable(context.DEPTH_TEST)
        context.enable(context.BLEND)
        context.blend_func = context.ONE, context.ONE_MINUS_SRC_ALPHA
        self._texture.use(0)
        set_uniforms(self._program, u_clip=clip, u_unit=unit, u_opacity=self.opacity)
        self._mesh.render()
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        context.enable(context.DEPTH_TEST)

    def _make(self) -> None:
        """Upload the picture that is to be shown."""
        context, before = self._context, self._context.fbo
        context.detect_framebuffer(0).use()
        self._held.release()
        self._made = self.shown
        if self.shown is not None:
            if self._program is None:
                self._program = self.own(program(context, "cabin", PANEL=2, LINEAR=1))
            from PIL import Image  # few dives have an overlay

            # Edges are mixed as they are seen: multiplied by their opacity.
            pixels = np.asarray(Image.fromarray(self.shown.pixels).convert("RGBa"))
            self._texture = self._held.own(upload(context, pixels[::-1]))
            self._texture.build_mipmaps()
            self._texture.filter = context.LINEAR_MIPMAP_LINEAR, context.LINEAR
            corners = fisheye_mesh(self.shown.tilt, self.shown.angle).astype("f4")
            (buffer,) = self._held.own_buffers(context, corners)
            content = [(buffer, "3f 4f", "in_place", "in_look")]
            self._mesh = self._held.own(context.vertex_array(self._program, content))
        before.use()
