"""The vessel around an observer in a headset: hoops, a floor, and a panel with text.

Drawn over the finished picture of each eye, at true scale. What rests around the observer is a
frame of rest against motion sickness.

Draws the vessel of a theatre and its panel on the canvas, in each view's own perspective.
"""

from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.view.camera import edge_tangents
from subsea.view.rig import CameraRig, Eye
from subsea.view.theatre_vessel import (
    PANEL,
    PANEL_SIZE,
    TheatreVessel,
    panel_quad,
    torus,
    vessel_plates,
    vessel_tube,
)

FLOOR_CM = 120.0  # below the eyes of a seated observer
RADIUS_CM = 78.0  # of the hoops
RAIL_CM = 52.0  # of the rail, below the eyes
TUBE_CM = 2.2
AROUND = 72  # corners of a hoop
DARK_FLOOR = 0.35  # brightness of the floor over that of the hoops
RIM = 0.31, 0.73  # rad, of the vignette: where it begins, where it is darkest
EVERYWHERE = -1.0, -0.5  # the same for a shade


class Cabin(GpuOwner):
    """Draws into the pictures of a headset's eyes, which its runtime owns."""

    def __init__(self, context: Any) -> None:
        """Compile; the context must be that of the pictures."""
        super().__init__()
        self._context = context
        self._metal, self._glass = (
            self.own(program(context, "cabin", PANEL=panel, LINEAR=0)) for panel in (0, 1)
        )
        self._shade = self.own(program(context, "vignette"))
        self._whole = self.own(context.vertex_array(self._shade, []))
        self._hoops = self._array(self._metal, vessel())
        self._quad = self._array(self._glass, panel_quad(PANEL))
        self._eyes: dict[int, Any] = {}  # framebuffers by the names of their textures
        self._held = self.own(GpuOwner())  # the panel
        self._panel: Any = None
        self.panel: Any = None  # the framebuffer of the panel

    def eye(self, texture: int, size: tuple[int, int]) -> Any:
        """The framebuffer of a picture that the runtime owns, by the name of its texture."""
        if texture not in self._eyes:
            colour = self._context.external_texture(texture, size, 4, 0, "f1")
            self._eyes[texture] = self._context.framebuffer([colour])
        return self._eyes[texture]

    def resize(self, size: tuple[int, int]) -> None:
        """Make the panel's framebuffer, unless it has that size."""
        if self._panel is not None and self._panel.size == size:
            return
        self._held.release()
        self._panel = self._held.own(self._context.texture(size, 4))
        self._panel.repeat_x = self._panel.repeat_y = False
        self.panel = self._held.own(self._context.framebuffer([self._panel]))

    def draw(self, into: Any, eye: Eye, light: Array, vignette: float, dark: float = 0.0) -> None:
        """Draw vignette, vessel and panel over the picture of an eye.

        `light` (3,) is the colour of the water around, `vignette` in [0, 1] the opacity of the rim,
        `dark` that of a shade over the sea.
        """
        context = self._context
        into.use()
        context.viewport = (0, 0, *into.size)
        context.disable(context.DEPTH_TEST)
        context.enable(context.BLEND)
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        for (begin, full), opacity in ((RIM, vignette), (EVERYWHERE, dark)):
            if opacity < 0.01:
                continue
            edges = edge_tangents(eye.projection)
            set_uniforms(self._shade, u_tangents=edges, u_rim=(begin, full, opacity))
            self._whole.render(vertices=3)
        clip = np.ascontiguousarray(clip_matrix(eye).T, "f4").tobytes()
        context.blend_func = context.ONE, context.ONE_MINUS_SRC_ALPHA
        set_uniforms(self._metal, u_clip=clip, u_light=tuple(map(float, light)))
        context.enable(context.CULL_FACE)
        self._hoops.render()
        context.disable(context.CULL_FACE)
        if self._panel is not None:
            self._panel.use(0)
            set_uniforms(self._glass, u_clip=clip)
            self._quad.render()
        context.disable(context.BLEND)
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA

    def forget(self) -> None:
        """Release the framebuffers over the runtime's textures, which are no longer valid."""
        for framebuffer in self._eyes.values():
            framebuffer.release()
        self._eyes.clear()

    def release(self) -> None:
        """Free every OpenGL object."""
        # moderngl binds the last framebuffer again when it makes one, which must not be freed.
        self._context.detect_framebuffer(0).use()
        self.forget()
        super().release()

    def _array(self, compiled: Any, corners: Array) -> Any:
        (buffer,) = self.own_buffers(self._context, corners.astype("f4"))
        content = [(buffer, "3f 4f", "in_place", "in_look")]
        return self.own(self._context.vertex_array(compiled, content))


def clip_matrix(eye: Eye) -> Array:
    """The matrix (4, 4) from the observer's axes right, up, ahead, cm, to an eye's clip space."""
    view = np.eye(4)
    view[:3, :3] = eye.axes * np.array([1.0, 1.0, -1.0])[:, None]  # the eye looks along -z
    view[:3, 3] = -view[:3, :3] @ eye.offset
    return np.asarray(eye.projection.astype(np.float64) @ view)


def vessel() -> Array:
    """Corners (n, 7) of triangles: place, cm, right, up, ahead; normal; brightness.

    A rail before and around the observer, a hoop from side to side overhead, and the floor.
    """
    right, up, ahead = np.eye(3)
    rail = _hoop(-RAIL_CM * up, right, ahead, 0.0, 2.0 * np.pi)
    low = -np.arcsin(RAIL_CM / RADIUS_CM)  # where the hoop would meet the rail's height
    hoop = _hoop(np.zeros(3), right, up, low, np.pi - low)
    return np.concatenate([_floor(), hoop, rail])


def _hoop(middle: Array, along: Array, up: Array, begin: float, end: float) -> Array:
    """Corners of an arc of a hoop in the plane of two unit vectors, between angles, rad."""
    return torus(middle, (along, up), (begin, end), (RADIUS_CM, TUBE_CM), AROUND)


def _floor() -> Array:
    """Corners of a disc under the observer, which faces up."""
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
    rim = RADIUS_CM * np.stack([np.cos(turn), np.zeros_like(turn), np.sin(turn)], axis=1)
    middle = np.zeros_like(rim[1:])
    place = np.stack([middle, rim[:-1], rim[1:]], axis=1).reshape(-1, 3) - (0.0, FLOOR_CM, 0.0)
    look = np.tile([0.0, 1.0, 0.0, DARK_FLOOR], (len(place), 1))
    return np.concatenate([place, look], axis=1)


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
