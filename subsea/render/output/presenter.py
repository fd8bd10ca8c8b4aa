"""A finished picture in a window that has no part in drawing it."""

from collections.abc import Callable, Sequence
from typing import Any

from subsea.render.gl.shaders import program


class Presenter:
    """Stretches textures of one context over the window of another that shares its objects.

    What a context draws with is its own (vertex arrays, programs, state), so each window has a
    presenter, made and used while that window is current.
    """

    def __init__(self, context: Any, page: Callable[[int], object] = lambda number: None) -> None:
        """`context` is the window's; `page` chooses a buffer of a window that has two."""
        self._context = context
        self._page = page
        self._program = program(context, "present")
        self._triangle = context.vertex_array(self._program, [])

    def show(self, pages: Sequence[Any], size: tuple[int, int]) -> None:
        """Fill the window of `size` pixels: one texture, or one for each eye.

        They must be finished: nothing makes one context wait for another.
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

    def release(self) -> None:
        """Free every OpenGL object."""
        self._triangle.release()
        self._program.release()
