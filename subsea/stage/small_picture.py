"""Small copies of a window's picture, which cost the dive little: made on the GPU, read later."""

import ctypes
from typing import Any

import numpy as np

from subsea.base.arrays import Bytes
from subsea.rendering.gl.context import GpuOwner, gl_function

# OpenGL enums
READ_FRAMEBUFFER, DRAW_FRAMEBUFFER, COLOR_BIT, LINEAR = 0x8CA8, 0x8CA9, 0x4000, 0x2601


class SmallPicture(GpuOwner):
    """Shrinks the screen of a context on the GPU, and reads the copy a frame later."""

    def __init__(self, context: Any, width: int, even: bool = False) -> None:
        """Copies are `width` pixels wide at most, and as high as the window's shape says.

        Films want `even` numbers of pixels.
        """
        super().__init__()
        self._context, self._width, self._even = context, width, even
        self._size = (0, 0)
        self._copied = False
        self._blit = gl_function(
            context, "glBlitFramebuffer", *[ctypes.c_int] * 8, ctypes.c_uint, ctypes.c_uint
        )
        self._bind = gl_function(context, "glBindFramebuffer", ctypes.c_uint, ctypes.c_uint)

    def copy(self, window: tuple[int, int], source: int | None = None) -> None:
        """Begin to copy the screen, whose size is that of the `window` in pixels.

        `source` is the OpenGL name of another framebuffer of that size.
        """
        context, width = self._context, min(self._width, window[0])
        size = width, max(round(width * window[1] / window[0]), 1)
        if self._even:
            size = max(size[0] // 2 * 2, 2), max(size[1] // 2 * 2, 2)
        if size != self._size:
            self.release()
            self._size = size
            texture = self.own(context.texture(size, 4))
            self._small = self.own(context.framebuffer([texture]))
            self._buffer = self.own(context.buffer(reserve=4 * size[0] * size[1]))
        self._bind(READ_FRAMEBUFFER, context.screen.glo if source is None else source)
        self._bind(DRAW_FRAMEBUFFER, self._small.glo)
        self._blit(0, 0, *window, 0, 0, *size, COLOR_BIT, LINEAR)
        self._small.read_into(self._buffer, components=4)
        context.screen.use()
        context.error  # clear it: moderngl asks for an attachment that windows lack  # noqa: B018
        self._copied = True

    def read(self) -> Bytes | None:
        """The copy (h, w, 4) that was begun last, top row first, once; None if there is none."""
        if not self._copied:
            return None
        self._copied = False
        width, height = self._size
        return np.frombuffer(self._buffer.read(), np.uint8).reshape(height, width, 4)[::-1]
