"""Presenting finished pictures in further windows."""

from collections.abc import Callable, Sequence
from typing import Any

from subsea.render.gl.owner import GpuOwner
from subsea.render.gl.shaders import program


class Presenter(GpuOwner):
    """Draws textures of one context over the window of another that shares its objects.

    Vertex arrays and state belong to one context, so each window needs a presenter of its own,
    made and used while that window is current.
    """

    def __init__(self, context: Any, page: Callable[[int], object] = lambda number: None) -> None:
        """Use the context of the window; `page` selects a buffer of a window that has two."""
        super().__init__()
        self._context = context
        self._page = page
        compiled = self.own(program(context, "present"))
        self._triangle = self.own(context.vertex_array(compiled, []))

    def show(self, pages: Sequence[Any], size: tuple[int, int]) -> None:
        """Fill the window of `size` pixels with one texture, or one for each eye.

        Nothing makes one context wait for another: the textures must be finished.
        """
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
