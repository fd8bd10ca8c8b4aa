"""Light that spreads around what is brighter than the picture can show."""

from typing import Any

from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.shaders import set_uniforms, source
from subsea.view.rig import Rect

ROWS = 200  # most rows of the blurred picture: the blur is a share of the height


class Bloom(GpuOwner):
    """Draws the bloom of a part of a canvas, small and blurred."""

    def __init__(self, context: Any) -> None:
        """Compile its passes."""
        super().__init__()
        self._context = context
        self._bright, self._smaller, self._blur = (
            self._pass(BRIGHT=bright, BLUR=blur) for bright, blur in ((1, 0), (0, 0), (0, 1))
        )
        self._held = self.own(GpuOwner())  # of the size below
        self._size = (0, 0)
        self._levels: list[tuple[Any, Any]] = []  # textures and their framebuffers

    def draw(self, canvas: Any, part: Rect) -> Any:
        """The bloom of a part of the canvas, in pixels: a texture, valid until the next."""
        if self._size != part[2:]:
            self._make(part[2:])
        context = self._context
        context.disable(context.DEPTH_TEST | context.BLEND | context.CULL_FACE)
        canvas.filter = context.LINEAR, context.LINEAR
        wide, high = canvas.size
        x, y, width, height = part
        before, shares = canvas, (x / wide, y / high, width / wide, height / high)
        passed = self._bright
        *levels, spare = self._levels
        for level in levels:
            # Between the first two texels of four and between the last two.
            step = 1.0 / before.size[0], 1.0 / before.size[1]
            before = self._draw(passed, before, level, shares, step)
            passed, shares = self._smaller, (0.0, 0.0, 1.0, 1.0)
        small = levels[-1]
        across, down = 1.0 / before.size[0], 1.0 / before.size[1]
        self._draw(self._blur, before, spare, shares, (across, 0.0))
        return self._draw(self._blur, spare[0], small, shares, (0.0, down))

    def _make(self, size: tuple[int, int]) -> None:
        """Textures of a quarter of the size before, down to few rows, and another of the last."""
        self._held.release()
        self._size, self._levels = size, []
        width, height = size
        while not self._levels or height > ROWS:
            width, height = max(width // 4, 1), max(height // 4, 1)
            self._levels.append(self._level((width, height)))
        self._levels.append(self._level((width, height)))

    def _level(self, size: tuple[int, int]) -> tuple[Any, Any]:
        texture = self._held.own(self._context.texture(size, 4, dtype="f2"))
        texture.repeat_x = texture.repeat_y = False
        return texture, self._held.own(self._context.framebuffer([texture]))

    def _pass(self, **constants: int) -> tuple[Any, Any]:
        compiled = self._context.program(
            vertex_shader=source("present.vert"),
            fragment_shader=source("bloom.frag", **constants),
        )
        return self.own(compiled), self.own(self._context.vertex_array(compiled, []))

    def _draw(
        self,
        passed: tuple[Any, Any],
        before: Any,
        into: tuple[Any, Any],
        shares: tuple[float, float, float, float],
        step: tuple[float, float],
    ) -> Any:
        compiled, triangle = passed
        texture, framebuffer = into
        framebuffer.use()
        self._context.viewport = (0, 0, *texture.size)
        set_uniforms(compiled, u_source=shares, u_step=step)
        before.use(0)
        triangle.render(vertices=3)
        return texture
