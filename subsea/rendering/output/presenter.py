"""Presenting finished pictures in further windows."""

from collections.abc import Callable, Sequence
from typing import Any

from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.shaders import program, set_uniforms


class Presenter(GpuOwner):
    """Draws textures of one context over the window of another that shares its objects.

    Vertex arrays and state belong to one context, so each window needs a presenter of its own,
    made and used while that window is current.
    """

    def __init__(
        self, context: Any, page: Callable[[int], object] = lambda number: None, pages: int = 1
    ) -> None:
        """Use the context of the window; `page` selects one of its `pages` buffers."""
        super().__init__()
        self._context = context
        self._page, self._pages = page, pages
        compiled = self.own(program(context, "present"))
        self._triangle = self.own(context.vertex_array(compiled, []))
        self._shade = self.own(program(context, "shade"))
        self._shaded = self.own(context.vertex_array(self._shade, []))

    def show(self, pages: Sequence[Any], size: tuple[int, int]) -> None:
        """Fill the window of `size` pixels with a finished texture, or one for each eye."""
        context = self._context
        context.screen.use()
        context.viewport = (0, 0, *size)
        context.disable(context.DEPTH_TEST | context.BLEND | context.CULL_FACE)
        for number, picture in enumerate(pages):
            self._page(number)
            seen = context.external_texture(picture.glo, picture.size, 4, 0, "f1")
            filtered = context.NEAREST if picture.size == size else context.LINEAR
            seen.filter = filtered, filtered
            seen.repeat_x = seen.repeat_y = False
            seen.use(0)
            self._triangle.render(vertices=3)

    def darken(self, shade: tuple[float, float, float, float], size: tuple[int, int]) -> None:
        """Blend a colour with opacity over all buffers of the window of `size` pixels."""
        context = self._context
        context.screen.use()
        context.viewport = (0, 0, *size)
        context.disable(context.DEPTH_TEST | context.CULL_FACE)
        context.enable(context.BLEND)
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        set_uniforms(self._shade, u_shade=shade)
        for number in range(self._pages):
            self._page(number)
            self._shaded.render(vertices=3)
        context.disable(context.BLEND)
