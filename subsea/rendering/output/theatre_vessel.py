"""Draws the vessel of a theatre and its panel on the canvas, in each view's own perspective."""

from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.rendering.output.cabin import clip_matrix
from subsea.view.rig import CameraRig
from subsea.view.theatre_vessel import (
    PANEL_SIZE,
    TheatreVessel,
    panel_quad,
    vessel_plates,
    vessel_tube,
)


class TheatreVesselRenderer(GpuOwner):
    """Draws a rig's vessel over its finished views, before tone mapping, warps and blends."""

    def __init__(self, context: Any) -> None:
        """Make nothing yet: most rigs have no vessel."""
        super().__init__()
        self.shown = True
        self._context = context
        self._held = self.own(GpuOwner())  # all of one vessel
        self._vessel: TheatreVessel | None = None
        self._parts: tuple[Any, ...] = ()  # plates, tube, quad of the panel
        self._panel: Any = None
        self._text: Any = None

    def panel(self, rig: CameraRig) -> Any:
        """The framebuffer of the panel with text; None if the rig's vessel has none."""
        self._take(rig.vessel)
        return self._panel

    def draw(self, rig: CameraRig, number: int, light: Array) -> None:
        """Draw it in the view `number` of a rig, into the framebuffer and viewport in use.

        `light` (3,) is the linear colour of the water around. Views beyond the rig's, such as
        retina pictures, have no vessel.
        """
        if rig.vessel is None or not self.shown or number >= len(rig.eyes):
            return
        self._take(rig.vessel)
        context = self._context
        clip = np.ascontiguousarray(clip_matrix(rig.eyes[number]).T, "f4").tobytes()
        context.disable(context.DEPTH_TEST)
        context.enable(context.BLEND)
        context.blend_func = context.ONE, context.ONE_MINUS_SRC_ALPHA
        set_uniforms(self._metal, u_clip=clip, u_light=tuple(map(float, np.sqrt(light))))
        self._parts[0].render()
        context.enable(context.CULL_FACE)
        self._parts[1].render()
        context.disable(context.CULL_FACE)
        if self._panel is not None:
            if number == 0:  # letters stay legible where they are small
                self._text.build_mipmaps()
            self._text.use(0)
            set_uniforms(self._glass, u_clip=clip)
            self._parts[2].render()
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        context.enable(context.DEPTH_TEST)

    def release(self) -> None:
        """Free every OpenGL object."""
        # moderngl binds the last framebuffer again when it makes one, which must not be freed.
        self._context.detect_framebuffer(0).use()
        super().release()

    def _take(self, vessel: TheatreVessel | None) -> None:
        """Make what a vessel needs, unless it is there."""
        if vessel == self._vessel:
            return
        context, held = self._context, self._held
        before = context.fbo
        context.detect_framebuffer(0).use()
        held.release()
        self._vessel, self._panel, self._text, self._parts = vessel, None, None, ()
        if vessel is not None:
            self._metal, self._glass = (
                held.own(program(context, "cabin", PANEL=panel, LINEAR=1)) for panel in (0, 1)
            )
            self._parts = (
                self._array(self._metal, vessel_plates(vessel)),
                self._array(self._metal, vessel_tube(vessel)),
            )
            if vessel.panel is not None:
                self._parts += (self._array(self._glass, panel_quad(vessel.panel)),)
                self._text = held.own(context.texture(PANEL_SIZE, 4))
                self._text.repeat_x = self._text.repeat_y = False
                self._panel = held.own(context.framebuffer([self._text]))
                self._panel.clear(0.0, 0.0, 0.0, 0.0)
        before.use()

    def _array(self, compiled: Any, corners: Array) -> Any:
        (buffer,) = self._held.own_buffers(self._context, corners.astype("f4"))
        content = [(buffer, "3f 4f", "in_place", "in_look")]
        return self._held.own(self._context.vertex_array(compiled, content))
