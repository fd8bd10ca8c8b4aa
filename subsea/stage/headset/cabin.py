"""The vessel around an observer in a headset: hoops, a floor, and a panel with text.

The vessel is a frame of rest against motion sickness.
"""

from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.rendering.output.vessel import VesselMesh
from subsea.view.camera import edge_tangents
from subsea.view.rig import Eye
from subsea.view.theatre_vessel import PANEL, torus

FLOOR_CM = 120.0  # below the eyes of a seated observer
RADIUS_CM = 78.0  # of the hoops
RAIL_CM = 52.0  # of the rail, below the eyes
TUBE_CM = 2.2
AROUND = 72  # corners of a hoop
DARK_FLOOR = 0.35  # brightness of the floor over that of the hoops
RIM = 0.31, 0.73  # rad, of the vignette: where it begins, where it is darkest
EVERYWHERE = -1.0, -0.5  # limits, as of RIM, of a shade


class Cabin(VesselMesh):
    """Draws into the pictures of a headset's eyes, which its runtime owns."""

    def __init__(self, context: Any) -> None:
        """Compile; the context must be that of the pictures."""
        super().__init__(context, False, vessel(), panel=PANEL)
        self._shade = self.own(program(context, "vignette"))
        self._whole = self.own(context.vertex_array(self._shade, []))
        self._eyes: dict[int, Any] = {}  # framebuffers by the names of their textures

    def eye(self, texture: int, size: tuple[int, int]) -> Any:
        """The framebuffer of a picture that the runtime owns, by the name of its texture."""
        if texture not in self._eyes:
            colour = self._context.external_texture(texture, size, 4, 0, "f1")
            self._eyes[texture] = self.own(self._context.framebuffer([colour]))
        return self._eyes[texture]

    def draw_over(
        self, into: Any, eye: Eye, light: Array, vignette: float, dark: float = 0.0
    ) -> None:
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
        self.draw(eye, light)
        context.disable(context.BLEND)


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
