"""Sunlight: shafts and shadows.

Shafts are a small map of directions about the sun, redrawn for every eye. Shadows are maps of the
distance to the sun: of all that stands, drawn once, and of the fishes in sight. Every shader that
includes `optics.glsl` reads them (`shadows.glsl`). They belong to the world, not to a view, so
shadows hold across screens.
"""

from collections.abc import Callable, Iterable
from typing import Any

import moderngl
import numpy as np

from subsea.base.arrays import Array
from subsea.habitat.stone import sun_at
from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.shaders import TEXTURE_UNITS, program, set_uniforms
from subsea.rendering.output.quality import Quality

REACH_CM = 650.0  # of the map of fishes, from the eye
DEEP_CM = 6000.0  # half the depth of that map
MARGIN_CM = 40.0  # about all that stands
MOVED_RAD = np.radians(1.0)  # of the sun, after which the maps are turned to it

Cast = Callable[[Any], object]  # draws with a program that has `u_view_projection`


def axes_of(sun: Array) -> Array:
    """Rows (3, 3): right and up on a map, and toward the sun."""
    across = np.array([sun[2], 0.0, -sun[0]]) / np.hypot(sun[0], sun[2])
    return np.stack([across, np.cross(sun, across), sun])


def map_of(axes: Array, middle: Array, halves: Array) -> Array:
    """The matrix (4, 4) from the world to clip space.

    `middle` (3,) and `halves` (3,) are those of a box along the `axes`, cm.
    """
    out = np.eye(4)
    out[:3, :3] = axes / (halves * (1.0, 1.0, -1.0))[:, None]
    out[:3, 3] = -out[:3, :3] @ middle
    return out


def around(axes: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Middle and half sizes, along `axes`, of the box that holds one along the world's axes."""
    corners = np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, 8).T @ axes.T
    first, last = corners.min(axis=0) - MARGIN_CM, corners.max(axis=0) + MARGIN_CM
    return 0.5 * (first + last) @ axes, 0.5 * (last - first)


class SunShadows(GpuOwner):
    """Draws the maps."""

    def __init__(self, context: Any, hour: float, box: Array) -> None:
        """`box` (2, 3) are the lowest and the highest corner of all that stands, cm."""
        super().__init__()
        self._context = context
        self._box = box
        self._standing: dict[str, Any] = {}  # uniforms of the map of what stands, once drawn
        self._turn(hour)
        self._program = self.own(program(context, "cast"))
        self._maps = self.own(GpuOwner())
        self._textures: list[Any] = []
        self._framebuffers: list[Any] = []
        self._sizes = 0, 0

    def _turn(self, hour: float) -> None:
        """Turn the maps to the sun at an hour; what stands is drawn again when next needed."""
        self._hour, self._axes = hour, axes_of(np.array(sun_at(hour)[0]))
        self._place = around(self._axes, self._box[0], self._box[1])
        self._standing = {}

    def adapt(self, quality: Quality) -> None:
        """Make maps of this quality; what stands is drawn again when next needed."""
        sizes = quality.sun_map, quality.fish_map if quality.sun_map else 0
        if sizes == self._sizes:
            return
        self._sizes, self._standing = sizes, {}
        self._context.detect_framebuffer(0).use()  # one in use must not be freed
        self._maps.release()
        self._textures = [self._texture(size) for size in sizes if size]
        self._framebuffers = [
            self._maps.own(self._context.framebuffer(depth_attachment=texture))
            for texture in self._textures
        ]

    @property
    def maps(self) -> int:
        """The number of maps that are drawn."""
        return len(self._textures)

    def draw(
        self,
        casts: Iterable[Cast],
        fishes: Callable[[dict[str, Any]], object],
        eye: Array,
        hour: float,
    ) -> dict[str, Any]:
        """Uniforms of the maps about an eye at an hour; empty without maps.

        `casts` draw what stands, `fishes` those in sight. Changes the framebuffer in use.
        """
        if not self.maps:
            return {}
        if hour != self._hour and self._axes[2] @ sun_at(hour)[0] < np.cos(MOVED_RAD):
            self._turn(hour)
        context = self._context
        context.disable(moderngl.BLEND)
        context.enable(moderngl.DEPTH_TEST)
        context.disable(moderngl.CULL_FACE)  # many shapes have no lower side
        context.polygon_offset = 2.0, 4.0
        if not self._standing:
            matrix = map_of(self._axes, *self._place)
            self._begin(0)
            set_uniforms(self._program, u_view_projection=_bytes(matrix))
            for cast in casts:
                cast(self._program)
            self._standing = {"u_sun_view": _bytes(TO_UNIT @ matrix)}
        uniforms = dict(self._standing)
        if len(self._textures) > 1:
            matrix = map_of(self._axes, eye, np.array([REACH_CM, REACH_CM, DEEP_CM]))
            self._begin(1)
            fishes({"u_view": _bytes(np.eye(4)), "u_projection": _bytes(matrix)})
            uniforms["u_fish_view"] = _bytes(TO_UNIT @ matrix)
        context.polygon_offset = 0.0, 0.0
        for name, texture in zip(("u_sun_map", "u_fish_map"), self._textures, strict=False):
            texture.use(TEXTURE_UNITS[name])
        return uniforms

    def _begin(self, number: int) -> None:
        framebuffer = self._framebuffers[number]
        framebuffer.use()
        self._context.viewport, self._context.scissor = (0, 0, *framebuffer.size), None
        framebuffer.clear(depth=1.0)

    def _texture(self, size: int) -> Any:
        texture = self._maps.own(self._context.depth_texture((size, size)))
        texture.compare_func = "<="
        texture.filter = moderngl.LINEAR, moderngl.LINEAR
        texture.repeat_x = texture.repeat_y = False
        return texture


TO_UNIT = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1.0]])


def _bytes(matrix: Array) -> bytes:
    return np.ascontiguousarray(matrix.T, np.float32).tobytes()


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
        self._map.use(TEXTURE_UNITS["u_shafts"])
