"""A vessel around the eyes, with a panel of text, at rest on the observer and at true scale.

The vessel of a theatre is drawn on the canvas, in each view's own perspective; that of a headset
(`stage.headset.cabin`) over the finished picture of each eye.
"""

from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.view.rig import CameraRig, Eye
from subsea.view.theatre_vessel import (
    PANEL_SIZE,
    Panel,
    TheatreVessel,
    panel_quad,
    vessel_plates,
    vessel_tube,
)


class VesselMesh(GpuOwner):
    """Draws the triangles of a vessel, and its panel if there is one."""

    def __init__(
        self,
        context: Any,
        linear: bool,
        solid: Array,
        plates: Array | None = None,
        panel: Panel | None = None,
    ) -> None:
        """Upload corners (n, 7): place, cm, right, up, ahead; normal; brightness.

        `plates` show both of their sides. The picture is `linear` light, or final colours.
        """
        super().__init__()
        self._context = context
        self._metal, self._glass = (
            self.own(program(context, "cabin", PANEL=panel, LINEAR=int(linear))) for panel in (0, 1)
        )
        self._solid = self._array(self._metal, solid)
        self._plates = None if plates is None else self._array(self._metal, plates)
        self._quad = None if panel is None else self._array(self._glass, panel_quad(panel))
        self._held = self.own(GpuOwner())  # the panel's picture
        self.text: Any = None  # the picture with the text, and its framebuffer
        self.panel: Any = None

    def resize(self, size: tuple[int, int]) -> None:
        """Make the panel's picture, unless it has that size."""
        if self.text is not None and self.text.size == size:
            return
        self._held.release()
        self.text = self._held.own(self._context.texture(size, 4))
        self.text.repeat_x = self.text.repeat_y = False
        self.panel = self._held.own(self._context.framebuffer([self.text]))

    def draw(self, eye: Eye, light: Array, unit: float = 1.0) -> None:
        """Draw it as an eye sees it, into the framebuffer and viewport in use.

        `light` (3,) is the final colour of the water around. A linear picture holds `unit` for a
        light of 1.
        """
        context = self._context
        clip = np.ascontiguousarray(clip_matrix(eye).T, "f4").tobytes()
        context.disable(context.DEPTH_TEST)
        context.enable(context.BLEND)
        context.blend_func = context.ONE, context.ONE_MINUS_SRC_ALPHA
        set_uniforms(self._metal, u_clip=clip, u_light=tuple(map(float, light)), u_unit=unit)
        if self._plates is not None:
            self._plates.render()
        context.enable(context.CULL_FACE)
        self._solid.render()
        context.disable(context.CULL_FACE)
        if self._quad is not None and self.text is not None:
            self.text.use(0)
            set_uniforms(self._glass, u_clip=clip, u_unit=unit)
            self._quad.render()
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA

    def release(self) -> None:
        """Free every OpenGL object."""
        # moderngl binds the last framebuffer again when it makes one, which must not be freed.
        self._context.detect_framebuffer(0).use()
        super().release()

    def _array(self, compiled: Any, corners: Array) -> Any:
        (buffer,) = self.own_buffers(self._context, corners.astype("f4"))
        content = [(buffer, "3f 4f", "in_place", "in_look")]
        return self.own(self._context.vertex_array(compiled, content))


class TheatreVesselRenderer(GpuOwner):
    """Draws a rig's vessel over its finished views, before tone mapping, warps and blends."""

    def __init__(self, context: Any) -> None:
        """Make nothing yet: most rigs have no vessel."""
        super().__init__()
        self.shown = True
        self._context = context
        self._held = self.own(GpuOwner())  # the mesh
        self._vessel: TheatreVessel | None = None
        self._mesh: VesselMesh | None = None

    def panel(self, rig: CameraRig) -> Any:
        """The framebuffer of the panel with text; None if the rig's vessel has none."""
        mesh = self._take(rig.vessel)
        return mesh and mesh.panel

    def draw(self, rig: CameraRig, number: int, light: Array, unit: float = 1.0) -> None:
        """Draw it in the view `number` of a rig, into the framebuffer and viewport in use.

        `light` (3,) is the linear colour of the water around, and `unit` is that of the canvas
        (`RenderTarget`). Views beyond the rig's, such as
        retina pictures, have no vessel.
        """
        mesh = self._take(rig.vessel)
        if mesh is None or not self.shown or number >= len(rig.eyes):
            return
        if mesh.text is not None and number == 0:  # letters stay legible where they are small
            mesh.text.build_mipmaps()
        mesh.draw(rig.eyes[number], np.sqrt(light), unit)
        self._context.enable(self._context.DEPTH_TEST)

    def _take(self, vessel: TheatreVessel | None) -> VesselMesh | None:
        """Return the mesh of a vessel, made unless it is there."""
        if vessel != self._vessel:
            before = self._context.fbo
            self._held.release()
            self._vessel, self._mesh = vessel, None
            if vessel is not None:
                parts = vessel_tube(vessel), vessel_plates(vessel), vessel.panel
                self._mesh = self._held.own(VesselMesh(self._context, True, *parts))
                if vessel.panel is not None:
                    self._mesh.resize(PANEL_SIZE)
                    self._mesh.panel.clear(0.0, 0.0, 0.0, 0.0)
            before.use()
        return self._mesh


def clip_matrix(eye: Eye) -> Array:
    """The matrix (4, 4) from the observer's axes right, up, ahead, cm, to an eye's clip space."""
    view = np.eye(4)
    view[:3, :3] = eye.axes * np.array([1.0, 1.0, -1.0])[:, None]  # the eye looks along -z
    view[:3, 3] = -view[:3, :3] @ eye.offset
    return np.asarray(eye.projection.astype(np.float64) @ view)
